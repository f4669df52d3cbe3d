"""What a robot refuses of a mission is refused on board and by the ground alike."""

import numpy as np
import pytest

import hypertuna as ht
from hypertuna import _core
from hypertuna.control.mission import Mission, Waypoint
from hypertuna.errors import InputError
from hypertuna.firmware.boards import find_firmware, started
from hypertuna.firmware.lockstep import LAST
from hypertuna.firmware.scenario import Scenario, scheduled_orders
from hypertuna.mission.checks import check_fit

FENCE = ((-40.0, -40.0), (40.0, -40.0), (40.0, 40.0), (-40.0, 40.0))


@pytest.fixture(scope="module")
def fish() -> ht.Robot:
    return ht.load("hypertuna")


def mission(
    depth: float = 1.0, radius: float = 2.0, y: float = 20.0, depth_max: float = 4.0, home_radius: float = 3.0
) -> Mission:
    waypoint = Waypoint(0.0, y, depth, 0.3, radius)
    return Mission((waypoint,), fence=FENCE, depth_max=depth_max, home_radius=home_radius)


def by_ground(robot: ht.Robot, flight: Mission) -> bool:
    try:
        check_fit(robot, flight)
    except InputError:
        return False
    return True


def on_board(flight: Mission) -> str:
    """Return the name of the refusal of a mission's last part."""
    steps = [step for _, step in scheduled_orders(Scenario("checked", flight))][:-2]  # without arming and start
    messages = np.concatenate([np.atleast_1d(step) for step in steps])
    messages["flags"][-1] |= LAST
    with started("pc", find_firmware("hypertuna", "pc")) as board:
        return str(_core.refusal_table()[board.run(messages)["refusal"][-1]][0])


@pytest.mark.parametrize(
    ("flight", "refusal"),
    [
        (mission(), "none"),
        (mission(radius=1.88), "too_small"),
        (mission(radius=1.91), "none"),
        (mission(home_radius=1.88), "too_small"),
        (mission(home_radius=1.91), "none"),
        (mission(y=37.1), "outside_fence"),
        (mission(y=36.9), "none"),
        (mission(depth=3.8), "too_deep"),
        (mission(depth=3.6), "none"),
        (mission(depth=0.0, depth_max=0.45), "too_deep"),
        (mission(depth=0.0, depth_max=0.55), "none"),
    ],
)
def test_both_refuse_the_same(fish: ht.Robot, flight: Mission, refusal: str) -> None:
    try:
        find_firmware("hypertuna", "pc")
    except InputError as error:
        pytest.skip(str(error))
    assert by_ground(fish, flight) == (refusal == "none")
    assert on_board(flight) == refusal
