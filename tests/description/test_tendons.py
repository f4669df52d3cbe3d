"""Joints on tendons: bends by the levers, as hand and linear algebra have them, and what is refused."""

from __future__ import annotations

import tomllib
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.actuation.new import first_robot
from hypertuna.description.robot import parse
from hypertuna.description.schema.hydraulics import Tendons


def document(**tendons: Any) -> dict[str, Any]:
    """A first robot of two joints on the tendons of one servo, with other values of their table."""
    found = tomllib.loads(first_robot("fish", links=3, joints=["tail"], actuation="tendons"))
    found["joints"][0]["tendons"] |= tendons
    return found


def test_two_joints_share_one_to_two() -> None:
    """Drum of 5 and 10 mm, levers of 10 mm at the tendons' own joints alone: q = phi/2 and phi."""
    tendons = parse(document(drum_m=[0.005, 0.01], lever_m=[[0.01], [0.0, 0.01]])).joints[0].tendons
    assert tendons is not None
    assert tendons.ratio == (0.5, 1.0)
    assert tendons.share == pytest.approx((1 / 3, 2 / 3), rel=1e-15)
    assert tendons.turns == pytest.approx(2 / 3, rel=1e-15)


def test_a_tendon_takes_in_the_bends_of_the_joints_that_it_passes() -> None:
    """Both wind on one radius of 10 mm, and the second passes the first joint at 4 mm: q_2 = (10 - 4) phi / 12."""
    tendons = Tendons.model_validate({"drum_m": [0.01, 0.01], "lever_m": [[0.01], [0.004, 0.012]]})
    assert tendons.ratio == pytest.approx((1.0, 0.5), rel=1e-15)
    assert Tendons.model_validate({"drum_m": [0.01, 0.01], "lever_m": [[0.01], [0.01, 0.012]]}).ratio == (1.0, 0.0)


def test_ratios_solve_the_equation_of_the_tendons() -> None:
    chance = np.random.default_rng(1)
    for n in range(1, 9):
        lever = np.tril(chance.uniform(-0.3, 0.5, (n, n)), -1) + np.diag(chance.uniform(0.5, 1.0, n))
        drum = chance.uniform(0.5, 2.0, n)
        rows = [row[: i + 1].tolist() for i, row in enumerate(lever)]
        tendons = Tendons.model_construct(drum=tuple(drum), lever=tuple(map(tuple, rows)))
        np.testing.assert_allclose(tendons.ratio, np.linalg.solve(lever, drum), rtol=1e-12)


REFUSED = {
    "joints[0].tendons.drum_m must be 2 long, one value per joint of the group": {
        "drum_m": [0.01],
        "lever_m": [[0.01]],
    },
    "joints[0].tendons.lever_m must be 2 lists, one for the tendon to each joint of drum_m, but is 1": {
        "lever_m": [[0.01]]
    },
    "joints[0].tendons.lever_m[1] must be 2 long, a lever at each joint up to the tendon's own": {
        "lever_m": [[0.01], [0.01]]
    },
    "joints[0].tendons.lever_m[1] must not end with 0": {"lever_m": [[0.01], [0.01, 0.0]]},
    "joints[0].tendons.lever_m[0] must be a list": {"lever_m": [0.01, 0.01]},
    "joints[0].tendons.drum_m[1] must be greater than 0": {"drum_m": [0.01, 0.0]},
    "lever_m must bend the joints of the group to one side in sum": {"lever_m": [[0.01], [0.0, -0.001]]},
    "lever_m must share the bend so that no joint bends more than ten times": {"lever_m": [[0.01], [0.0, -0.0105]]},
    "joints[0].bend_max_deg must leave joint 2 within its stop_deg = 10": {
        "lever_m": [[0.01], [0.0, 0.01]],
        "stop_deg": [90.0, 10.0],
    },
}


@pytest.mark.parametrize("text", REFUSED)
def test_what_does_not_bend_every_joint_by_one_drum_is_refused(text: str) -> None:
    with pytest.raises(ht.InputError) as caught:
        parse(document(**{"drum_m": [0.01, 0.01]} | REFUSED[text]))
    assert text in str(caught.value)


def test_tendons_and_what_they_replace_do_not_stand_together() -> None:
    for key, value in {"share": [0.5, 0.5], "drive_units": 4}.items():
        found = document()
        found["joints"][0] |= {key: value}
        with pytest.raises(ht.InputError, match=rf"joints\[0\].{key} must not stand beside joints\[0\]."):
            parse(found)
    found = document()
    found["joints"] += [found["joints"][0] | {"name": "second"}]  # a joint that two motors bend
    with pytest.raises(ht.InputError, match="must be in one joint group only"):
        parse(found)


def test_the_written_file_has_the_tendons_alone() -> None:
    robot = parse(document())
    assert "share" not in robot.document()["joints"][0]
    assert parse(robot.document()) == robot
