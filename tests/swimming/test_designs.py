"""A number that changes no settled beat is no design variable, and the error says why it changes none."""

import pytest

import hypertuna as ht
from hypertuna.swimming.designs import design_of


@pytest.mark.parametrize(
    ("robot", "key", "ends", "reason"),
    [
        ("hypertuna", "water.strip.edge_lift", (0.5, 1.0), "the robot swims in lumped water"),
        ("hypertuna", "joints.I.bandwidth", (5.0, 10.0), "the robot's joints are ideal"),
        ("hypertuna", "battery.capacity", (1.0, 2.0), "a settled beat does not know it"),
    ],
)
def test_why_a_variable_changes_no_beat(robot: str, key: str, ends: tuple[float, float], reason: str) -> None:
    fish = ht.load(robot)
    with pytest.raises(ht.InputError, match=f"its derivative is zero everywhere: leave it out: {reason}"):
        design_of(fish.using(joints="ideal") if "bandwidth" in key else fish, {key: ends})
