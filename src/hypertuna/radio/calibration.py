"""Calibration: fit zero and scale of a sensor, or trim of a servo, to readings beside a reference."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.io.tables import parse_float, read_table
from hypertuna.ranges import CELL

# Kind of sensor: unit of the reference, and its value of 1 in SI.
KINDS = {
    "bend": ("deg", 180 / math.pi),
    "pressure": ("kPa", 1e-3),
    "current": ("A", 1.0),
    "servo": ("deg", 180 / math.pi),
}
COLUMNS = ("sensor", "counts", "reference")
MICRO = 1e-6
SCATTER_MAX = 0.1  # rms of the residuals over the references' span

Pair = tuple[str, float, float]  # sensor, counts of its converter (of a servo: pulse in us), reference [SI]


@dataclass(frozen=True)
class Calibration:
    """Calibration of a sensor or servo."""

    sensor: str  # name, such as bend_0
    parameters: dict[str, float]  # values to set on the robot [SI]
    rms: float  # of the residuals, in SI of the reference
    points: int

    @property
    def reading(self) -> tuple[float, str]:
        """The residuals' rms in the unit in which people read the reference, and that unit."""
        unit, factor = KINDS[parse_sensor(self.sensor)[0]]
        return self.rms * factor, unit

    def record(self) -> dict[str, Any]:
        """Return the JSON record."""
        rms, unit = self.reading
        return {"sensor": self.sensor, "points": self.points, f"rms_{unit.lower()}": rms, "parameters": self.parameters}


def parse_sensor(text: str) -> tuple[str, int]:
    """Return kind and number of a sensor or servo, such as pressure_3."""
    match = re.fullmatch(r"([a-z]+)_(\d)", text)
    if match is None or match[1] not in KINDS:
        fix = did_you_mean(text, [f"{kind}_0" for kind in KINDS])
        raise InputError("must name a sensor or a servo by kind and number", key="sensor", value=shown(text), fix=fix)
    return match[1], int(match[2])


def read_pairs(path: str | Path) -> list[Pair]:
    """Read a CSV file with the columns sensor, counts (servo: pulse [us]), reference [deg, kPa or A]."""
    table = read_table(path)
    if sorted(table.head) != sorted(COLUMNS):
        rule, fix = f"must be {', '.join(COLUMNS)}", "rename the columns"
        raise InputError(rule, file=table.file, key=f"line {table.line}", value=", ".join(table.head), fix=fix)
    return table.parse(_pair)


def _pair(_: int, cells: dict[str, str]) -> Pair:
    """Return the pair of a row."""
    unit, factor = KINDS[parse_sensor(cells["sensor"])[0]]
    counts = CELL.check(parse_float(cells["counts"]), "counts", "give a number")
    reference = CELL.check(parse_float(cells["reference"]), "reference", f"give it in {unit}")
    return cells["sensor"], counts, reference / factor


def calibrate(pairs: Sequence[Pair], *, pulse_center: float = 1500e-6) -> tuple[Calibration, ...]:
    """Fit a straight line to each sensor: reference = scale (counts - zero); `pulse_center` [s]."""
    calibrations = []
    for sensor in sorted({name for name, _, _ in pairs}):
        kind, number = parse_sensor(sensor)
        table = np.array([(counts, reference) for name, counts, reference in pairs if name == sensor])
        counts, reference = table[:, 0], table[:, 1]
        if len(np.unique(reference)) < 2:
            fix = "measure at two or more references"
            raise InputError("must have different references", key=sensor, value=f"{len(table)} rows at one", fix=fix)
        spread = counts - counts.mean()
        if not np.any(np.abs(spread) > 0):
            raise InputError("must change with the reference", key=sensor, value="stuck", fix="check its wires")
        scale = float(spread @ (reference - reference.mean()) / (spread @ spread))
        if scale == 0:
            raise InputError("must change with the reference", key=sensor, value="noise alone", fix="check its wires")
        zero = float(counts.mean() - reference.mean() / scale)
        rms = float(np.sqrt(np.mean((scale * (counts - zero) - reference) ** 2)))
        if rms > SCATTER_MAX * np.ptp(reference):
            unit, factor = KINDS[kind]
            value = f"off it by {rms * factor:.3g} {unit} of {np.ptp(reference) * factor:.3g} {unit}"
            fix = "hold it still at each reference, and check its wires"
            raise InputError("must follow the reference on a straight line", key=sensor, value=value, fix=fix)
        if kind == "servo":
            parameters = {f"servo_trim_{number}": zero * MICRO - pulse_center}
        else:
            parameters = {f"{kind}_zero_{number}": zero, f"{kind}_scale_{number}": scale}
        calibrations.append(Calibration(sensor, parameters, rms, len(table)))
    return tuple(calibrations)
