"""What notebooks and shells show of trials."""

import numpy as np

from hypertuna.display import Card, curve_svg, number
from hypertuna.swimming.cards import gait_text
from hypertuna.trials.manifest import Recording
from hypertuna.trials.smoothing import SmoothSeries
from hypertuna.trials.tracks import JointSeries, Track
from hypertuna.trials.trials import Trials


def trials_card(trials: Trials) -> Card:
    """Show the runs."""
    facts = [("steady runs", f"{len(trials.steady)}"), ("tracked recordings", f"{len(trials.recordings)}")]
    rows = [
        (run.name, gait_text(run.gait), number(run.speed if run.speed is not None else np.nan, "m/s"))
        for run in trials.steady
    ]
    rows += [(one.name, f"{len(one.tracks)} tracked runs", "") for one in trials.recordings]
    return Card(f"Trials: {len(trials.runs)} runs", facts, "", ("run", "gait", "speed"), rows)


def recording_card(recording: Recording) -> Card:
    """Show the size of a recording."""
    series = recording.joints
    facts = [*_series_facts(series), ("tracked runs", f"{len(recording.tracks)}")]
    return Card(f"Recording {recording.name}", facts, picture=lambda: _series_svg(series))


def series_card(series: JointSeries) -> Card:
    """Show length and ranges of measured joint angles."""
    return Card("Measured joint angles", _series_facts(series), picture=lambda: _series_svg(series))


def smooth_card(smoothed: SmoothSeries) -> Card:
    """Show the curves of smoothed joint angles."""
    noise = ", ".join(number(float(level), digits=2) for level in np.degrees(smoothed.noise))
    kinds = ", ".join(dict.fromkeys(type(curve).__name__ for curve in smoothed.curves))
    facts = [*_series_facts(smoothed.series), ("noise", f"{noise} deg"), ("curves", kinds)]
    return Card("Smoothed joint angles", facts, picture=lambda: _series_svg(smoothed.series))


def track_card(track: Track) -> Card:
    """Show length and path of a tracked run."""
    facts = [("frames", f"{len(track.time)}"), ("time", f"{track.time[0]:g} to {track.time[-1]:g} s")]
    x, y = track.pose[:, 0], track.pose[:, 1]
    return Card(f"Track {track.run}", facts, picture=lambda: curve_svg(x, y, "y [m] over x [m]", equal=True))


def _series_facts(series: JointSeries) -> list[tuple[str, str]]:
    """Return samples, time and ranges of joint angles."""
    spans = (
        f"{low:.3g} to {high:.3g}" for low, high in np.degrees([series.angle.min(axis=0), series.angle.max(axis=0)]).T
    )
    return [
        ("samples", f"{len(series.time)}"),
        ("time", f"{series.time[0]:g} to {series.time[-1]:g} s"),
        ("angles", f"{', '.join(spans)} deg"),
    ]


def _series_svg(series: JointSeries) -> str:
    """Draw the angle of the last joint group."""
    return curve_svg(series.time, np.degrees(series.angle[:, -1]), "angle of the last joint group [deg] over time [s]")
