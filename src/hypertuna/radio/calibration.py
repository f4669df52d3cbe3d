"""Calibration: fit a sensor's zero and scale, or a servo's trim, to readings at known references."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.io.door import RUNS
from hypertuna.io.tables import parse_float, read_table
from hypertuna.ranges import CELL

# By kind of sensor: unit in which people give the reference, and factor from SI to that unit.
KINDS = {
    "bend": ("deg", 180 / math.pi),
    "pressure": ("kPa", 1e-3),
    "current": ("A", 1.0),
    "voltage": ("V", 1.0),
    "depth": ("m", 1.0),
    "servo": ("deg", 180 / math.pi),
    "accelerometer": ("m/s^2", 1.0),
    "gyroscope": ("rad/s", 1.0),
    "compass": ("%", 100.0),
}
AXES = ("accelerometer", "gyroscope", "compass")  # sensors with three axes, calibrated in imu.py
SINGLE = ("voltage", "depth", *AXES)  # sensors of which a robot has one: their names have no number
COLUMNS = ("sensor", "counts", "reference")  # names of the columns of a CSV file
MICRO = 1e-6  # seconds per microsecond
SCATTER_MAX = 0.1  # largest rms of the residuals, as a fraction of the references' range

Pair = tuple[str, float, float]  # sensor, counts of the A/D converter (for a servo: pulse in us), reference [SI]


@dataclass(frozen=True)
class Calibration:
    """Result of calibrating a sensor or servo: parameters to set on the robot, and residuals."""

    sensor: str  # name, such as bend_0
    parameters: dict[str, float]  # values to set on the robot [SI]
    rms: float  # rms of the residuals, in the SI unit of the reference
    points: int
    notes: tuple[str, ...] = ()  # further sentences on the fit

    @property
    def reading(self) -> tuple[float, str]:
        """The residuals' rms in the unit of `KINDS`, and that unit."""
        unit, factor = KINDS[parse_sensor(self.sensor)[0]]
        return self.rms * factor, unit

    def record(self) -> dict[str, Any]:
        """Return the JSON record."""
        rms, unit = self.reading
        name = {"m/s^2": "m_s2", "rad/s": "rad_s", "%": "percent"}.get(unit, unit.lower())
        fit = {"sensor": self.sensor, "points": self.points, f"rms_{name}": rms}
        return fit | {"parameters": self.parameters, "notes": list(self.notes)}


def parse_sensor(text: str) -> tuple[str, int]:
    """Split the name of a sensor or servo, such as pressure_3, into kind and number; the number of depth is 0."""
    if text in SINGLE:
        return text, 0
    match = re.fullmatch(r"([a-z]+)_(\d)", text)
    if match is None or match[1] not in KINDS or match[1] in SINGLE:
        fix = did_you_mean(text, [kind if kind in SINGLE else f"{kind}_0" for kind in KINDS])
        raise InputError("must name a sensor or a servo by kind and number", key="sensor", value=shown(text), fix=fix)
    return match[1], int(match[2])


def zero_and_scale(sensor: str) -> tuple[str, str]:
    """Return the names of a sensor's parameters for zero and scale, such as bend_zero_0 and bend_scale_0."""
    kind, number = parse_sensor(sensor)
    suffix = "" if kind in SINGLE else f"_{number}"
    return f"{kind}_zero{suffix}", f"{kind}_scale{suffix}"


def read_pairs(path: str | Path) -> list[Pair]:
    """Read a CSV file with the columns sensor, counts (servo: pulse [us]), reference (in the unit of `KINDS`)."""
    table = read_table(path, RUNS)
    if sorted(table.head) != sorted(COLUMNS):
        rule, fix = f"must name the columns {', '.join(COLUMNS)}", "rename the columns"
        raise InputError(rule, file=table.file, key=f"line {table.line}", value=", ".join(table.head), fix=fix)
    return table.parse(_pair)


def _pair(_: int, cells: dict[str, str]) -> Pair:
    """Return sensor, counts and reference [SI] of a row."""
    kind, _ = parse_sensor(cells["sensor"])
    if kind in AXES:
        fix = f"calibrate it live: --sensor {kind} --connect ..."
        raise InputError("must be a sensor that a CSV file calibrates", key="sensor", value=cells["sensor"], fix=fix)
    unit, factor = KINDS[kind]
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
            rule, value = "must be measured at two or more references", f"measured at one, in {len(table)} rows"
            raise InputError(rule, key=sensor, value=value, fix="add a reference")
        deviation = counts - counts.mean()
        if not np.any(np.abs(deviation) > 0):
            raise InputError("must change with the reference", key=sensor, value="stuck", fix="check its wires")
        scale = float(deviation @ (reference - reference.mean()) / (deviation @ deviation))
        if scale == 0:
            raise InputError("must change with the reference", key=sensor, value="only noise", fix="check its wires")
        zero = float(counts.mean() - reference.mean() / scale)
        rms = float(np.sqrt(np.mean((scale * (counts - zero) - reference) ** 2)))
        if rms > SCATTER_MAX * np.ptp(reference):
            unit, factor = KINDS[kind]
            value = f"off by {rms * factor:.3g} {unit} rms over {np.ptp(reference) * factor:.3g} {unit}"
            fix = "hold it still at each reference, and check its wires"
            raise InputError("must follow the reference along a straight line", key=sensor, value=value, fix=fix)
        if kind == "depth":  # the robot measures its zero at the surface, since air pressure changes
            parameters = {zero_and_scale(sensor)[1]: scale}
        elif kind == "servo":
            parameters = {f"servo_trim_{number}": zero * MICRO - pulse_center}
        else:
            parameters = dict(zip(zero_and_scale(sensor), (zero, scale), strict=True))
        calibrations.append(Calibration(sensor, parameters, rms, len(table)))
    return tuple(calibrations)
