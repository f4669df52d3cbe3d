"""Silicone: elastic constants of a material from a tensile test.

A file has a header of any length, a row of column names with units, and rows of numbers, separated by semicolons or
commas. Engineering strain and stress are used, true ones where the file has no others. Strain is a fraction, or in
percent if its name ends in (%).
"""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hypertuna.arrays import Array
from hypertuna.errors import InputError, shown
from hypertuna.io.tables import parse_float, read_lines
from hypertuna.ranges import CELL, POSITIVE

UP_TO = 1.0  # engineering strain up to which a test is fitted; data sheets give the modulus at this strain
POINTS_MIN = 5  # fewest rows for a fit
STRAIN_MAX = 20.0  # larger strains must be in percent: the softest silicones break at 10 to 17
PASCALS = {"pa": 1.0, "kpa": 1e3, "mpa": 1e6}  # Pa by unit of a column's name


class Mooney(NamedTuple):
    """Constants of a two-term Mooney-Rivlin solid [Pa] (Eq. 7)."""

    c1: float
    c2: float

    @property
    def modulus(self) -> float:
        """Young's modulus at small strain, 6 (C1 + C2) [Pa]."""
        return 6 * (self.c1 + self.c2)

    @property
    def modulus_100(self) -> float:
        """Engineering stress at 100 % strain, 3.5 (C1 + C2/2) [Pa]."""
        return 3.5 * (self.c1 + self.c2 / 2)


@dataclass(frozen=True)
class TensileTest:
    """A tensile test: strain [1] and engineering stress [Pa]."""

    name: str  # name of the material, else of the file
    strain: Array  # (points,) engineering strain
    stress: Array  # (points,) Pa, engineering stress
    omitted: int  # number of rows of the file without strain or stress


@dataclass(frozen=True)
class TensileFit:
    """Mooney-Rivlin constants fitted to a tensile test, with the rows used and the residual stress."""

    solid: Mooney  # Pa, with C1 and C2 not negative
    free: Mooney  # Pa, of the unconstrained fit, in which C1 or C2 may be negative
    up_to: float  # largest engineering strain of the rows fitted
    requested: float  # largest engineering strain to fit
    ended: bool  # whether the test ends before `requested`
    points: int  # number of rows fitted
    rms: float  # Pa, root mean square of the residual stress
    stress_100: float  # Pa, measured engineering stress at 100 % strain; NaN if the test ends before

    @property
    def status(self) -> str:
        """Sentence on the fit: the rows used, and the constants at their bound of 0."""
        bound = [name for name, value in zip(("C1", "C2"), self.solid, strict=True) if value == 0]
        reason = f", where the test ends ({100 * self.requested:.4g} % was requested)" if self.ended else ""
        fitted = f"Fitted to {self.points} rows up to {100 * self.up_to:.0f} % strain{reason}."
        if not bound:
            return fitted
        free = ", ".join(f"{name} = {value / 1e3:.1f} kPa" for name, value in zip(("C1", "C2"), self.free, strict=True))
        return f"{fitted} {bound[0]} is at its bound of 0: unconstrained, {free}, which is unstable in compression."


def read_tensile(path: str | Path) -> TensileTest:
    """Read a tensile test from a CSV file; errors name file and line."""
    file, lines = str(path), read_lines(path)
    top, columns, (percent, scale), true = _columns(lines, file)
    separator = ";" if ";" in lines[top] else ","
    rows, omitted = [], 0
    for k, line in enumerate(lines[top + 1 :], start=top + 2):
        cells = [cell.strip() for cell in line.split(separator)]
        if not any(cells):
            continue
        values = [cells[c] if c < len(cells) else "" for c in columns]  # rows may be short
        if not all(values):
            omitted += 1
            continue
        rows.append([_number(cell, f"{file}:{k}") for cell in values])
    strain, stress = np.array(rows, dtype=np.float64).reshape(-1, 2).T
    strain, stress = percent * strain, scale * stress
    if true:
        strain, stress = np.expm1(np.minimum(strain, STRAIN_MAX)), stress * np.exp(-strain)
    if len(strain) and strain.max() > STRAIN_MAX:
        rule = "must be a fraction, 1 where the length has doubled"
        value, fix = f"up to {max(float(row[0]) for row in rows):g}", "divide it by 100, or end its name in (%)"
        raise InputError(rule, file=file, key=lines[top].split(separator)[columns[0]].strip(), value=value, fix=fix)
    header = (line.split(separator) for line in lines[:top])
    names = (cells[1].strip() for cells in header if cells[0].strip() == "Material" and len(cells) > 1)
    return TensileTest(next(names, "") or Path(path).stem, strain, stress, omitted)


def fit_silicone(test: TensileTest, *, up_to: float = UP_TO) -> TensileFit:
    """Fit a two-term Mooney-Rivlin solid to a tensile test: least squares of the engineering stress, C1, C2 >= 0.

    The stress in uniaxial tension is 2 (lambda - lambda^-2) (C1 + C2 / lambda). Negative constants, frequent in
    unconstrained fits, make a solid that is unstable in compression. `up_to` is the largest engineering strain to fit.
    """
    from scipy.optimize import nnls

    POSITIVE.check(up_to, "up_to", "give the largest strain to fit")
    if len(test.strain) and not (test.strain > 0).any():
        rule, fix = "must have positive strains: a test in tension", "change the sign, or give a test in tension"
        raise InputError(rule, key=test.name, value=f"at most {test.strain.max():g}", fix=fix)
    used = (test.strain > 0) & (test.strain <= up_to)
    if used.sum() < POINTS_MIN:
        rule = f"must have {POINTS_MIN} rows with a strain up to {100 * up_to:g} %"
        raise InputError(rule, key=test.name, value=f"{used.sum()}", fix="fit a larger range, or check the units")
    stretch, stress = 1 + test.strain[used], test.stress[used]
    basis = 2 * (stretch - stretch**-2)
    design = np.stack([basis, basis / stretch], axis=1)
    constrained = nnls(design, stress)[0]
    if not constrained.any():
        rule = "must have positive stresses at positive strains: a test in tension"
        value, fix = f"{stress.mean():.4g} Pa on the mean", "change the sign of the stress, or give a test in tension"
        raise InputError(rule, key=test.name, value=value, fix=fix)
    unconstrained = np.linalg.lstsq(design, stress, rcond=None)[0]
    order = np.argsort(test.strain, kind="stable")
    at_100 = np.interp(1.0, test.strain[order], test.stress[order], right=np.nan)
    return TensileFit(
        solid=Mooney(*map(float, constrained)),
        free=Mooney(*map(float, unconstrained)),
        up_to=float(test.strain[used].max()),
        requested=up_to,
        ended=bool(test.strain.max() < up_to),
        points=int(used.sum()),
        rms=float(np.sqrt(np.mean((design @ constrained - stress) ** 2))),
        stress_100=float(at_100),
    )


def _columns(lines: list[str], file: str) -> tuple[int, tuple[int, int], tuple[float, float], bool]:
    """Return the row of names; the columns of strain and stress, and their factors to SI; whether they are true."""
    for k, line in enumerate(lines):
        names = [name.strip().lower() for name in re.split(r"[;,]", line)]
        for kind in ("engineering", "true"):
            strain = next((i for i, name in enumerate(names) if name.startswith(f"{kind} strain")), None)
            stress = next((i for i, name in enumerate(names) if name.startswith(f"{kind} stress")), None)
            if strain is None or stress is None:
                continue
            unit = re.search(r"\((\w+)\)", names[stress])
            if unit is None or unit[1] not in PASCALS:
                value = unit[1] if unit else "none"
                rule, fix = "must give the unit of the stress as (Pa), (kPa) or (MPa)", "write Engineering Stress (MPa)"
                raise InputError(rule, file=f"{file}:{k + 1}", value=value, fix=fix)
            percent = 0.01 if "%" in names[strain] or "percent" in names[strain] else 1.0
            return k, (strain, stress), (percent, PASCALS[unit[1]]), kind == "true"
    rule = "must have a row of names with Engineering Strain and Engineering Stress (MPa)"
    raise InputError(rule, file=file, fix="add it above the numbers; True Strain and True Stress are accepted, too")


def _number(text: str, place: str) -> float:
    """Return the number in a cell; errors name its place in the file."""
    value = parse_float(text)
    if not np.isfinite(value):
        raise InputError("must be a finite number", file=place, value=shown(text), fix="correct or empty that cell")
    return CELL.check(value, "", "correct or empty that cell", file=place)
