"""Figures of missions: all of the course is shown, in the middle, as large as the width lets it be."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.patches import Circle, Polygon

from hypertuna.mission.file import MissionFile, read_mission


def moved(east: float, north: float, stretch: float) -> MissionFile:
    """The mission «box», moved from its origin and stretched toward the north."""
    file = read_mission("box")
    mission = file.mission

    def place(x: float, y: float) -> tuple[float, float]:
        return x + east, stretch * y + north

    waypoints = []
    for point in mission.waypoints:
        x, y = place(point.x, point.y)
        waypoints.append(point._replace(x=x, y=y))
    start, home, fence = place(*mission.start), place(*mission.home), tuple(place(*corner) for corner in mission.fence)
    changed = replace(mission, start=start, home=home, fence=fence, waypoints=tuple(waypoints))
    return replace(file, mission=changed)


@pytest.mark.parametrize("stretch", [0.3, 1.0, 3.0])
def test_all_of_the_course_is_shown_in_the_middle(stretch: float) -> None:
    file, width = moved(500.0, -300.0, stretch), 6.0
    figure = file.plot(width=width)
    axes = figure.axes[0]
    places = [file.mission.start, file.mission.home]
    for patch in axes.patches:
        if isinstance(patch, Circle):
            (x, y), radius = patch.center, patch.radius
            places += [(x - radius, y - radius), (x + radius, y + radius)]
        elif isinstance(patch, Polygon):
            places += patch.get_xy().tolist()
    low, high = np.min(places, axis=0), np.max(places, axis=0)
    shown = np.array([axes.get_xlim(), axes.get_ylim()]).T
    np.testing.assert_allclose(shown.mean(axis=0), (low + high) / 2)
    assert (shown[0] < low).all()
    assert (high < shown[1]).all()
    assert (np.diff(shown, axis=0) < 1.5 * (high - low)).any()
    wide, tall = np.ptp(shown, axis=0)
    assert figure.get_figheight() - 1.1 == pytest.approx(min(0.86 * tall / wide, 0.8) * width)
