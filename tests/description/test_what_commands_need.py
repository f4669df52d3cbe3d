"""What `robot check` accepts, the commands can use; what they cannot, they refuse in a sentence and in time."""

import copy
import time
from typing import Any

import numpy as np
import pytest

from hypertuna.actuation.sizing import size_pump
from hypertuna.description.robot import load, parse
from hypertuna.errors import InputError
from hypertuna.simulation.posture import fitted_peaks, peak_bends

TUNA = load("hypertuna").document()


def changed(*changes: tuple[str, Any]) -> dict[str, Any]:
    """HyperTuna's document with other values, places separated by dots."""
    document = copy.deepcopy(TUNA)
    for place, value in changes:
        *path, last = (int(part) if part.isdigit() else part for part in place.split("."))
        table: Any = document
        for part in path:
            table = table[part]
        table[last] = value
    return document


@pytest.mark.parametrize(
    ("place", "value", "sentence"),
    [
        (
            "drive_unit.hose",
            "DR1",
            "drive_unit.hose must be a material of the table [materials], but is 'DR1': did you",
        ),
        ("drive_unit.matrix", "EC5O", "drive_unit.matrix must be a material of the table [materials], but is 'EC5O'"),
        ("materials", {}, "drive_unit.hose must be a material of the table [materials], but is 'DR10': add that table"),
        ("guidance.gaits", ["unoptimised-0.3"] * 13, "guidance.gaits must have 1 to 12 gaits, but is 13: omit some"),
        (
            "oil.bulk_modulus_pa",
            1400.0,
            "oil.bulk_modulus_pa must be at least 1e+08: no liquid is softer, but is 1400:",
        ),
    ],
)
def test_the_check_refuses_what_the_twin_cannot_use(place: str, value: Any, sentence: str) -> None:
    document = changed((place, value)) | {"sources": {}}
    with pytest.raises(InputError) as caught:
        parse(document)
    assert sentence in str(caught.value)


@pytest.mark.parametrize(
    "changes",
    [
        [("servos.1.bandwidth_hz", 1e5)],
        [("servos.1.inertia_kg_m2", 1e-12)],
        [("oil.density_kg_m3", 1e-6)],
    ],
)
def test_the_pump_refuses_what_is_too_stiff_at_once(changes: list[tuple[str, Any]]) -> None:
    robot, start = parse(changed(*changes)), time.monotonic()
    with pytest.raises(InputError, match=r"joints\[0\].line must not be so stiff that a run needs steps of less than"):
        size_pump(robot, frequency=[6.0], amplitude=[0.1, 0.1])
    assert time.monotonic() - start < 10


NARROW = ("joints.0.line.bore_m", 0.004), ("joints.1.line.bore_m", 0.004), ("oil.air", 0.01)


def test_the_pump_refuses_what_takes_too_many_steps() -> None:
    robot, start = (
        parse(changed(("oil.viscosity_100_m2_s", 6.8e-7), ("joints.0.line.compliance_m3_pa", 2e-14), *NARROW)),
        time.monotonic(),
    )
    with pytest.raises(InputError, match=r"settle within 80 s|joints\[0\].line must not be so narrow and so stiff"):
        size_pump(robot, frequency=[3.0], amplitude=[0.1, 0.15])
    assert time.monotonic() - start < 10


def test_a_posture_test_of_a_run_that_diverged_at_once_has_no_beats() -> None:
    for time_, angle in ((np.empty(0), np.empty(0)), (np.zeros(1), np.zeros(1)), (np.arange(3) / 100, np.zeros(3))):
        for peaks in (peak_bends, fitted_peaks):
            end, values = peaks(time_, angle, 2.0)
            assert (len(end), values.shape) == (0, (0, 2))
