"""Calibration: from readings beside a reference to the zero and the scale that the robot keeps."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hypertuna.errors import InputError, did_you_mean, shown
from hypertuna.io.tables import check_width, read_rows
from hypertuna.ranges import FINITE

__all__ = ["KINDS", "Calibration", "Pair", "calibrate", "read_pairs", "sensor_of"]

# What is calibrated: the reference's unit as people read it, and how much of it is 1 in SI.
KINDS = {
    "bend": ("deg", 180 / math.pi),
    "pressure": ("kPa", 1e-3),
    "current": ("A", 1.0),
    "servo": ("deg", 180 / math.pi),
}
COLUMNS = ("sensor", "counts", "reference")
MICRO = 1e-6
SCATTER = 0.1  # rms from the line over the references' span, that is no calibration any more

Pair = tuple[str, float, float]  # sensor, counts of its converter (of a servo: pulse in us), reference [SI]


@dataclass(frozen=True)
class Calibration:
    """What a sensor's or a servo's readings say."""

    sensor: str  # Its name, such as ``bend_0``
    parameters: dict[str, float]  # What the robot is to keep [SI]
    rms: float  # Of what the straight line leaves, in SI of the reference
    points: int


def sensor_of(text: str) -> tuple[str, int]:
    """Read the name of a sensor or servo."""
    found = re.fullmatch(r"([a-z]+)_(\d)", text)
    if found is None or found[1] not in KINDS:
        fix = did_you_mean(text, [f"{kind}_0" for kind in KINDS])
        raise InputError("must name a sensor or a servo by kind and number", key="sensor", value=shown(text), fix=fix)
    return found[1], int(found[2])


def read_pairs(path: str | Path) -> list[Pair]:
    """Read readings and references from a CSV file: sensor, counts, reference.

    The reference is in deg (bend, servo), kPa (pressure) or A (current); the counts of a servo are its pulse in us.
    """
    file = str(path)
    (line, head), *rows = read_rows(path)
    if sorted(head) != sorted(COLUMNS):
        value = ", ".join(head)
        raise InputError(
            f"must be {', '.join(COLUMNS)}", file=file, key=f"line {line}", value=value, fix="name them so"
        )
    pairs = []
    for number, cells in rows:
        check_width(cells, head, file=file, line=number)
        row = dict(zip(head, cells, strict=True))
        try:
            kind, _ = sensor_of(row["sensor"])
            unit, factor = KINDS[kind]
            counts = FINITE.check(_float(row["counts"]), "counts", "give a number")
            reference = FINITE.check(_float(row["reference"]), "reference", f"give it in {unit}")
        except InputError as error:
            key = f"line {number}, {error.key}"
            raise InputError(error.rule, file=file, key=key, value=error.value, fix=error.fix) from None
        pairs.append((row["sensor"], counts, reference / factor))
    return pairs


def calibrate(pairs: Sequence[Pair], *, pulse_center: float = 1500e-6) -> tuple[Calibration, ...]:
    """Fit a straight line to each sensor: reference = scale (counts - zero); `pulse_center` [s]."""
    found = []
    for sensor in sorted({name for name, _, _ in pairs}):
        kind, number = sensor_of(sensor)
        table = np.array([(counts, reference) for name, counts, reference in pairs if name == sensor])
        counts, reference = table[:, 0], table[:, 1]
        if len(np.unique(reference)) < 2:
            fix = "measure at two references at least"
            raise InputError("must have different references", key=sensor, value=f"{len(table)} rows at one", fix=fix)
        spread = counts - counts.mean()
        if not np.any(np.abs(spread) > 0):
            raise InputError("must change with the reference", key=sensor, value="stuck", fix="check its wires")
        scale = float(spread @ (reference - reference.mean()) / (spread @ spread))
        if scale == 0:
            raise InputError("must change with the reference", key=sensor, value="noise alone", fix="check its wires")
        zero = float(counts.mean() - reference.mean() / scale)
        rms = float(np.sqrt(np.mean((scale * (counts - zero) - reference) ** 2)))
        if rms > SCATTER * np.ptp(reference):
            unit, factor = KINDS[kind]
            value = f"off it by {rms * factor:.3g} {unit} of {np.ptp(reference) * factor:.3g} {unit}"
            fix = "hold it still at each reference, and check its wires"
            raise InputError("must follow the reference on a straight line", key=sensor, value=value, fix=fix)
        if kind == "servo":
            keep = {f"servo_trim_{number}": zero * MICRO - pulse_center}
        else:
            keep = {f"{kind}_zero_{number}": zero, f"{kind}_scale_{number}": scale}
        found.append(Calibration(sensor, keep, rms, len(table)))
    return tuple(found)


def _float(text: str) -> float:
    """Read a number; NaN for what is none."""
    try:
        return float(text)
    except ValueError:
        return math.nan
