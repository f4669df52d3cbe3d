"""Family of actuators: designs within the bounds that meet a bench, and measurements that would tell them apart."""

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

MEMBERS = 300  # members of a family by default
MODEL_ERROR = 0.03  # error of the fast model, compared with finite elements, relative (docs/fe.md)
COUNT, ERROR = Whole(min=50, max=5000), Range(min=0, max=0.5)  # allowed number of members, and allowed model error
PARTS = 100  # steps of progress in each stage
INTERVAL = (0.05, 0.5, 0.95)  # quantiles: lower end of the 90 % interval, median and upper end
NODES, DEGREE = 5, 3  # instrument errors per member (quadrature), and degree of a quantity's polynomial in the reading
SPLIT = 0.25  # a gap wider than this part of the expected values' interval splits the interval into two
MISREAD = 3.0  # a value was misread if the family's median is more standard deviations away
TINY = 1e-12  # keeps logarithms and quotients finite
NARROWED = 0.9  # a quantity is listed if a measurement shortens its interval below this part


@dataclass(frozen=True)
class OpenQuantity:
    """A quantity of a joint that the bench does not measure, with its value in each member."""

    text: str
    unit: str
    values: Array  # (members,), values of the members in `unit`

    @property
    def interval(self) -> tuple[float, float, float]:
        """Lower end of the 90 % interval, median and upper end."""
        low, middle, high = np.quantile(self.values, INTERVAL).tolist()
        return low, middle, high


@dataclass(frozen=True)
class Next:
    """A further measurement, with its expected readings and the quantities that it would narrow."""

    text: str
    unit: str
    bits: float  # expected information gain: sum of log2 of the factors by which it narrows the open quantities
    expected: tuple[tuple[float, float], ...]  # in `unit`: 90 % of the values, as two intervals if a gap splits them
    narrows: dict[str, float]  # interval after over before, for each quantity narrowed by a tenth or more


@dataclass(frozen=True)
class Family(Plotted, Tabular, data=lambda family: family.rows):
    """A sample of the designs that meet a bench; all members have equal weight."""

    space: Designs
    population: Population
    found: Array  # (members, elements), computed values [SI]
    quantities: tuple[OpenQuantity, ...]  # quantities that the bench does not measure
    next: tuple[Next, ...]  # further measurements, the most informative first
    middle: int  # index of the member nearest to the medians
    seed: int
    model_error: float
    seconds: float

    @property
    def members(self) -> tuple[Design, ...]:
        """The designs of the sample."""
        return self.population.members

    @property
    def values(self) -> Array:
        """Values of the unknowns (members, n) [SI]."""
        return np.array([member.values for member in self.members])

    @property
    def rows(self) -> list[dict[str, Any]]:
        """Unknowns with their bounds, 90 % intervals and the chosen member, lengths in mm and angles in degrees."""
        rows = []
        for k, u in enumerate(self.space.free):
            unit, factor = BORDER[u.unit]
            low, median, high = np.quantile(factor * self.values[:, k], INTERVAL).tolist()
            bounds = {"lower": u.lower * factor, "upper": u.upper * factor}
            interval = {"low": low, "median": median, "high": high}
            chosen = {"chosen": float(self.values[self.middle, k]) * factor}
            rows.append({"name": u.name, "unit": unit, "described": u.described * factor} | bounds | interval | chosen)
        return rows

    @property
    def facts(self) -> list[dict[str, Any]]:
        """Measured values, with the values of the family and of the chosen member, in displayed units."""
        measured, bench, rows = self.space.elements, self.space.bench, []
        for e, (kind, row) in enumerate(zip(measured.kind.tolist(), measured.row.tolist(), strict=True)):
            factor = KINDS[kind].factor
            low, median, high = np.quantile(factor * self.found[:, e], INTERVAL).tolist()
            place = {"file": bench.files[row], "line": bench.lines[row]}
            side, branch = (*SIDES, BOTH)[int(bench.side[row])], BRANCHES[int(bench.unload[row])]
            source = {"joint": self.space.robot.joints[bench.joint[row]].name, "side": side, "branch": branch}
            source |= {"pressure_kpa": bench.pressure[row] / 1e3}
            quantity = {"kind": kind, "unit": KINDS[kind].unit, "measured": factor * measured.measured[e]}
            quantity |= {"sd": factor * self.space.sd[e], "low": low, "median": median, "high": high}
            off = (self.found[self.middle, e] - measured.measured[e]) / self.space.sd[e]
            rows.append(place | source | quantity | {"chosen": factor * self.found[self.middle, e], "residual": off})
        return rows

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings of the bench, and warnings on measured values far from the family's median."""
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
            {"quantity": item.text, "unit": item.unit}
            | dict(zip(("low", "median", "high"), item.interval, strict=True))
            | {"chosen": float(item.values[self.middle])}
            for item in self.quantities
        ]
        return {
            "members": len(self.members),
            "distinct": len({id(item) for item in self.members}),
            "unknowns": self.rows,
            "facts": self.facts,
            "ranges": ranges,
            "next": [vars(item) for item in self.next],
            "chosen": self.middle,
            "values": {item.name: self.values[:, k] * BORDER[item.unit][1] for k, item in enumerate(self.space.free)},
            "quantities": {item.text: item.values for item in self.quantities},
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
    """Sample the designs of an actuator that meet a bench; docs/bench.md has the method.

    free, bounds: as for `fit_bench`, but priors are uniform between the bounds, and the buckling of the axis is an
    unknown too. members: size of the sample. model_error: error of the fast model, relative to each measured value.
    """
    started = time.monotonic()
    COUNT.check(members, "members", "leave it out")
    ERROR.check(model_error, "model error", "give it as a fraction, such as 0.03")
    space = designs(robot, bench, free, bounds=bounds, model_error=model_error)

    def report(stage: int, done: int, total: int) -> None:  # stage 0 draws designs, 1 ranks measurements
        if progress is not None:
            progress(PARTS * stage + PARTS * done // total, 2 * PARTS)

    population = populate(space, members, seed=seed, progress=partial(report, 0))
    robots = [c.robot for c in population.members]
    found = np.array([space.elements.of(computed(c, bench)) for c in robots])
    quantities = tuple(OpenQuantity(c.text, c.unit, _values(c, robots)) for c in open_quantities(robot, bench))
    middle = _middle(space, population.members, quantities, (found - space.elements.measured) / space.sd)
    measurements, possible = [], candidates(robot, bench, space.free)
    for k, c in enumerate(possible, 1):
        measurements += [measurement] if (measurement := _next(c, _values(c, robots), quantities)) is not None else []
        report(1, k, len(possible))
    ranked = tuple(sorted(measurements, key=lambda c: -c.bits))
    return Family(space, population, found, quantities, ranked, middle, seed, model_error, time.monotonic() - started)


def chosen_robot(family: Family) -> Robot:
    """Return the robot of the chosen member, with the family named as the source of changed values."""
    space, low, high = family.space, *np.quantile(family.values, (INTERVAL[0], INTERVAL[-1]), axis=0)
    chosen = family.members[family.middle]
    texts: dict[str, list[str]] = {}
    for k, unknown in enumerate(space.free):
        unit, factor = BORDER[unknown.unit]
        interval = f"{low[k] * factor:.3g} to {high[k] * factor:.3g} {unit}".removesuffix(" 1")
        for key in keys_of(space.robot, unknown):
            texts.setdefault(key, []).append(f"{unknown.name} {chosen.values[k] * factor:.3g} (90 % from {interval})")
    files = ", ".join(dict.fromkeys(space.bench.files))
    origin = f"one of {len(family.members)} designs of hypertuna joint family (seed {family.seed}) that meet {files}"
    return sourced(chosen.robot, space.robot, {key: f"{origin}: {', '.join(parts)}" for key, parts in texts.items()})


def _middle(space: Designs, members: Sequence[Design], quantities: Sequence[OpenQuantity], off: Array) -> int:
    """Return the index of the member nearest the median unknowns and quantities, with small residuals `off`."""
    unknowns = np.array([[u.log(v) for u, v in zip(space.free, m.values.tolist(), strict=True)] for m in members])
    logs = np.hstack([unknowns, np.log(np.maximum([m.values for m in quantities], TINY)).T])
    distances = (logs - np.median(logs, axis=0)) / np.maximum(logs.std(axis=0), TINY)
    return int(np.argmin((distances**2).sum(axis=1) + (off**2).sum(axis=1)))


def _values(candidate: Candidate, robots: Sequence[Robot]) -> Array:
    """Return a measurement's value for every robot (members,), in its displayed unit."""
    return candidate.factor * np.array([candidate.of(robot) for robot in robots])


def _next(candidate: Candidate, values: Array, quantities: Sequence[OpenQuantity]) -> Next | None:
    """Return the measurement, and how it narrows each quantity; None if its noise is 0. values: of the members.

    Each member gives a reading for each error of the instrument. The logarithm of each quantity is fitted by a cubic
    in the logarithm of the reading; its residuals over its own spread are the factor of narrowing.
    """
    sd = np.array([candidate.factor * candidate.noise(value / candidate.factor) for value in values.tolist()])
    if not (sd > 0).all():
        return None
    nodes, weights = np.polynomial.hermite_e.hermegauss(NODES)
    reading = np.log(np.maximum(values + np.outer(nodes, sd), sd / 2)).ravel()
    root_weights = np.sqrt(np.repeat(weights / weights.sum() / len(values), len(values)))
    terms = np.vander((reading - reading.mean()) / max(float(reading.std()), TINY), DEGREE + 1)
    logs = np.log(np.maximum([quantity.values for quantity in quantities], TINY)).T
    centered = np.tile(logs - logs.mean(axis=0), (NODES, 1)) * root_weights[:, np.newaxis]
    weighted = terms * root_weights[:, np.newaxis]
    residuals = centered - weighted @ np.linalg.lstsq(weighted, centered, rcond=None)[0]
    ratio = np.linalg.norm(residuals, axis=0) / np.maximum(np.linalg.norm(centered, axis=0), TINY)
    narrows = {quantities[q].text: float(ratio[q]) for q in np.argsort(ratio).tolist() if ratio[q] < NARROWED}
    bits = float(-np.log2(np.clip(ratio, TINY, 1.0)).sum())
    return Next(candidate.text, candidate.unit, bits, _expected(values), narrows)


def _expected(values: Array) -> tuple[tuple[float, float], ...]:
    """Return the interval with 90 % of the values, as two intervals where a gap splits them."""
    low, _, high = np.quantile(values, INTERVAL).tolist()
    inside = np.sort(values[(low <= values) & (values <= high)])
    smallest_part = len(inside) // 10  # fewest members of each interval
    gaps = np.diff(inside)[smallest_part : len(inside) - smallest_part]
    if not len(gaps) or gaps.max() <= SPLIT * (high - low):
        return ((low, high),)
    k = smallest_part + int(np.argmax(gaps))
    return (low, float(inside[k])), (float(inside[k + 1]), high)
