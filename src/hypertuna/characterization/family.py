"""Family of actuators: all designs within the bounds that meet a bench, and what to measure next to tell them apart."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from hypertuna.actuation.hydraulics import SIDES
from hypertuna.arrays import Array
from hypertuna.characterization.data import BOTH, BRANCHES, KINDS, Bench
from hypertuna.characterization.designs import Design, Designs, designs
from hypertuna.characterization.experiment_design import Candidate, candidates, open_quantities
from hypertuna.characterization.population import Population, populate
from hypertuna.characterization.problem import computed
from hypertuna.characterization.unknowns import BORDER, keys_of, sourced
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import Robot
from hypertuna.display import Plotted, Tabular
from hypertuna.ranges import Range, Whole

MEMBERS = 300
MODEL_ERROR = 0.03  # of the fast model beside finite elements, relative (docs/fe.md)
COUNT, ERROR = Whole(min=50, max=5000), Range(min=0, max=0.5)
PARTS = 100  # of a stage, for the progress
INTERVAL = (0.05, 0.5, 0.95)
NODES, DEGREE = 5, 3  # errors of an instrument for each member, and polynomial of a quantity in its readings
SPLIT = 0.25  # part of the range of expected values: a wider gap splits them into two
MISREAD = 3.0  # residual, in standard deviations, in the middle of the family
TINY = 1e-12
NARROWED = 0.9  # of its interval: ranges narrowed less are not listed


@dataclass(frozen=True)
class Quantity:
    """A quantity of a joint that the bench leaves open."""

    text: str
    unit: str
    values: Array  # (members,), in `unit`

    @property
    def interval(self) -> tuple[float, float, float]:
        """Lower end of the 90 % interval, median and upper end."""
        low, middle, high = np.quantile(self.values, INTERVAL).tolist()
        return low, middle, high


@dataclass(frozen=True)
class Next:
    """A further measurement, and what it would tell."""

    text: str
    unit: str
    bits: float  # expected information gain on the open quantities: sum of log2 of how much narrower each gets
    expected: tuple[tuple[float, float], ...]  # in `unit`: 90 % of the values, in two parts where a gap splits them
    narrows: dict[str, float]  # interval after over before, by quantity, of those narrowed by a tenth or more


@dataclass(frozen=True)
class Family(Plotted, Tabular, data=lambda family: family.rows):
    """A sample of the designs that meet a bench; all members count alike."""

    space: Designs
    population: Population
    found: Array  # (members, elements), computed values [SI]
    quantities: tuple[Quantity, ...]
    next: tuple[Next, ...]  # the most informative first
    middle: int  # index of the member nearest to the medians
    seed: int
    model_error: float
    seconds: float

    @property
    def members(self) -> tuple[Design, ...]:
        """Designs of the sample, each with its robot."""
        return self.population.members

    @property
    def values(self) -> Array:
        """Unknowns (members, n) [SI]."""
        return np.array([one.values for one in self.members])

    @property
    def rows(self) -> list[dict[str, Any]]:
        """Unknowns with their bounds, 90 % intervals and the chosen member, lengths in mm and angles in degrees."""
        rows = []
        for k, one in enumerate(self.space.free):
            unit, factor = BORDER[one.unit]
            low, median, high = np.quantile(factor * self.values[:, k], INTERVAL).tolist()
            bounds = {"lower": one.lower * factor, "upper": one.upper * factor}
            ends = {"low": low, "median": median, "high": high}
            chosen = {"chosen": float(self.values[self.middle, k]) * factor}
            rows.append({"name": one.name, "unit": unit, "described": one.described * factor} | bounds | ends | chosen)
        return rows

    @property
    def facts(self) -> list[dict[str, Any]]:
        """Measured values with those of the family and of the chosen member, in displayed units."""
        measured, bench, rows = self.space.elements, self.space.bench, []
        for e, (kind, row) in enumerate(zip(measured.kind.tolist(), measured.row.tolist(), strict=True)):
            factor = KINDS[kind].factor
            low, median, high = np.quantile(factor * self.found[:, e], INTERVAL).tolist()
            place = {"file": bench.files[row], "line": bench.lines[row]}
            side, branch = (*SIDES, BOTH)[int(bench.side[row])], BRANCHES[int(bench.unload[row])]
            where = {"joint": self.space.robot.joints[bench.joint[row]].name, "side": side, "branch": branch}
            where |= {"pressure_kpa": bench.pressure[row] / 1e3}
            told = {"kind": kind, "unit": KINDS[kind].unit, "measured": factor * measured.measured[e]}
            told |= {"sd": factor * self.space.sd[e], "low": low, "median": median, "high": high}
            off = (self.found[self.middle, e] - measured.measured[e]) / self.space.sd[e]
            rows.append(place | where | told | {"chosen": factor * self.found[self.middle, e], "residual": off})
        return rows

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings of the bench, and of measured values that no design comes near to."""
        far = [
            f"{one['file']}, line {one['line']}: the {one['kind']} is {one['measured']:.3g} {one['unit']}, but "
            f"{one['median']:.3g} in the middle of the family: it was misread, or its standard deviation is larger."
            for one in self.facts
            if abs(one["median"] - one["measured"]) > MISREAD * one["sd"]
        ]
        return (*self.space.bench.warnings, *far)

    @property
    def record(self) -> dict[str, Any]:
        """Record of the family, for JSON."""
        population = self.population
        ranges = [
            {"quantity": one.text, "unit": one.unit}
            | dict(zip(("low", "median", "high"), one.interval, strict=True))
            | {"chosen": float(one.values[self.middle])}
            for one in self.quantities
        ]
        return {
            "members": len(self.members),
            "distinct": len({id(one) for one in self.members}),
            "unknowns": self.rows,
            "facts": self.facts,
            "ranges": ranges,
            "next": [vars(one) for one in self.next],
            "chosen": self.middle,
            "values": {one.name: self.values[:, k] * BORDER[one.unit][1] for k, one in enumerate(self.space.free)},
            "quantities": {one.text: one.values for one in self.quantities},
            "warnings": self.warnings,
            "seed": self.seed,
            "model_error": self.model_error,
            "draws": population.tried,
            "evaluations": population.evaluations,
            "powers": population.powers,
            "seconds": self.seconds,
            **provenance(self.space.robot),
        }


def family(
    robot: Robot,
    bench: Bench,
    free: Sequence[str] | str | None = None,
    *,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    members: int = MEMBERS,
    model_error: float = MODEL_ERROR,
    seed: int = 0,
    progress: Callable[[int, int], None] | None = None,
) -> Family:
    """Sample the designs of an actuator that meet a bench: docs/bench.md has the method.

    free, bounds: as for `fit_bench`, but all unknowns are alike within their bounds, and what holds the axis is one of
    them. members: size of the sample. model_error: of the fast model, relative to each measured value.
    """
    begun = time.monotonic()
    COUNT.check(members, "members", "leave it out")
    ERROR.check(model_error, "model error", "give it as a fraction, such as 0.03")
    space = designs(robot, bench, free, bounds=bounds, model_error=model_error)

    def report(stage: int, done: int, total: int) -> None:  # drawn, and then judged
        if progress is not None:
            progress(PARTS * stage + PARTS * done // total, 2 * PARTS)

    population = populate(space, members, seed=seed, progress=partial(report, 0))
    fish = [one.robot for one in population.members]
    found = np.array([space.elements.of(computed(one, bench)) for one in fish])
    quantities = tuple(Quantity(one.text, one.unit, _of(one, fish)) for one in open_quantities(robot, bench))
    middle = _middle(space, population.members, quantities, (found - space.elements.measured) / space.sd)
    more, ahead = [], candidates(robot, bench, space.free)
    for k, one in enumerate(ahead, 1):
        more += [judged] if (judged := _next(one, _of(one, fish), quantities)) is not None else []
        report(1, k, len(ahead))
    ranked = tuple(sorted(more, key=lambda one: -one.bits))
    return Family(space, population, found, quantities, ranked, middle, seed, model_error, time.monotonic() - begun)


def chosen_robot(family: Family) -> Robot:
    """Return the chosen member as a robot, with the family as the source of what differs from the description."""
    space, low, high = family.space, *np.quantile(family.values, (INTERVAL[0], INTERVAL[-1]), axis=0)
    chosen = family.members[family.middle]
    texts: dict[str, list[str]] = {}
    for k, one in enumerate(space.free):
        unit, factor = BORDER[one.unit]
        ends = f"{low[k] * factor:.3g} to {high[k] * factor:.3g} {unit}".removesuffix(" 1")
        for key in keys_of(space.robot, one):
            texts.setdefault(key, []).append(f"{one.name} {chosen.values[k] * factor:.3g} (90 % from {ends})")
    files = ", ".join(dict.fromkeys(space.bench.files))
    what = f"one of {len(family.members)} designs of hypertuna joint family (seed {family.seed}) that meet {files}"
    return sourced(chosen.robot, space.robot, {key: f"{what}: {', '.join(parts)}" for key, parts in texts.items()})


def _middle(space: Designs, members: Sequence[Design], quantities: Sequence[Quantity], off: Array) -> int:
    """Return the member whose unknowns, open quantities and residuals (members, elements) are nearest to the middle."""
    unknowns = np.array([[u.log(v) for u, v in zip(space.free, one.values.tolist(), strict=True)] for one in members])
    logs = np.hstack([unknowns, np.log(np.maximum([one.values for one in quantities], TINY)).T])
    away = (logs - np.median(logs, axis=0)) / np.maximum(logs.std(axis=0), TINY)
    return int(np.argmin((away**2).sum(axis=1) + (off**2).sum(axis=1)))


def _of(one: Candidate, fish: Sequence[Robot]) -> Array:
    """Compute a quantity of every member (members,), in its displayed unit."""
    return one.factor * np.array([one.of(robot) for robot in fish])


def _next(one: Candidate, values: Array, quantities: Sequence[Quantity]) -> Next | None:
    """Judge a measurement by its values (members,) in the family; None for one that is always 0.

    Each member, with each error of the instrument, makes a reading. How much narrower the logarithm of a quantity is
    about its cubic in the logarithm of the reading is what the reading tells.
    """
    sd = np.array([one.factor * one.noise(value / one.factor) for value in values.tolist()])
    if not (sd > 0).all():
        return None
    nodes, share = np.polynomial.hermite_e.hermegauss(NODES)
    reading = np.log(np.maximum(values + np.outer(nodes, sd), sd / 2)).ravel()
    root = np.sqrt(np.repeat(share / share.sum() / len(values), len(values)))
    terms = np.vander((reading - reading.mean()) / max(float(reading.std()), TINY), DEGREE + 1)
    logs = np.log(np.maximum([quantity.values for quantity in quantities], TINY)).T
    about = np.tile(logs - logs.mean(axis=0), (NODES, 1)) * root[:, np.newaxis]
    weighted = terms * root[:, np.newaxis]
    left = about - weighted @ np.linalg.lstsq(weighted, about, rcond=None)[0]
    ratio = np.linalg.norm(left, axis=0) / np.maximum(np.linalg.norm(about, axis=0), TINY)
    narrows = {quantities[q].text: float(ratio[q]) for q in np.argsort(ratio).tolist() if ratio[q] < NARROWED}
    bits = float(-np.log2(np.clip(ratio, TINY, 1.0)).sum())
    return Next(one.text, one.unit, bits, _expected(values), narrows)


def _expected(values: Array) -> tuple[tuple[float, float], ...]:
    """Return 90 % of the values, as two intervals where a gap splits them."""
    low, _, high = np.quantile(values, INTERVAL).tolist()
    inside = np.sort(values[(low <= values) & (values <= high)])
    few = len(inside) // 10  # members that make a part of their own
    gaps = np.diff(inside)[few : len(inside) - few]
    if not len(gaps) or gaps.max() <= SPLIT * (high - low):
        return ((low, high),)
    k = few + int(np.argmax(gaps))
    return (low, float(inside[k])), (float(inside[k + 1]), high)
