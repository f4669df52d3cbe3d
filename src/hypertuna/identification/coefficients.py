"""Free coefficients: names, ties, bounds and scales, and robots with given values of them."""

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from hypertuna.arrays import Array
from hypertuna.description.robot import Robot, parse
from hypertuna.errors import InputError
from hypertuna.identification.columns import (
    SPRINGS,
    column_key,
    column_of,
    file_key,
    is_spring,
    parameter_name,
    parameter_rows,
    with_springs,
    write_column,
)
from hypertuna.identification.names import (
    COMMON,
    NUISANCES,
    SIGNED,
    FreeValue,
    Names,
    bounds_table,
    factor_table,
    value_of,
)
from hypertuna.identification.truncated_normal import truncated_normal
from hypertuna.ranges import NOT_NEGATIVE, Range
from hypertuna.swimming.model import core_model
from hypertuna.trials.kind import Point

OFFSETS = ("time_offset", *(f"{table}.{value}" for table in ("joints", *SPRINGS) for value in SIGNED))
ABSOLUTE_UNITS = dict.fromkeys(OFFSETS, 0.1)  # s, rad: units of errors that are not relative
MAX_BOUND = 1e12  # largest magnitude of a bound [SI]
ABOVE_ONE = Range(above=1)  # factors of priors
LOG_DECADES = 4  # decades below the upper bound, for the lower bound in log scale if the default is 0


@dataclass(frozen=True)
class Free:
    """A free coefficient: one value for one parameter of the robot, or for several tied parameters."""

    # Such as water.lumped.drag[1-6]: a column of `parameter_names`, and the indices that share the value. With =common
    # at the end, the value is a factor on the present values.
    name: str
    lower: float  # bounds [SI]
    upper: float
    start: float  # value at which the first search starts [SI]
    scale: Literal["natural", "log"] = "natural"  # in which the search works and the error is normal
    prior: tuple[float, float] | None = None  # value known without the trials [SI], and factor by which it may be off

    @property
    def column(self) -> str:
        """Column of the robot's model: the name without its indices."""
        return self.name.removesuffix(COMMON).partition("[")[0]

    @property
    def index(self) -> str:
        """Text between the name's brackets; empty without brackets."""
        return self.name.removesuffix(COMMON).partition("[")[2].removesuffix("]")

    @property
    def common(self) -> bool:
        """Whether the value is a factor on the present values."""
        return self.name.endswith(COMMON)

    @property
    def indices(self) -> tuple[int, ...]:
        """Indices in the column that share the value; (0,) for a column of one value."""
        return FreeValue(self.column, self.index).members

    @property
    def unit(self) -> str:
        """SI unit."""
        if self.column in NUISANCES:
            return NUISANCES[self.column]
        if self.common:
            return "1"
        unit = column_key(self.column)[1] or "1"
        return {"deg": "rad"}.get(unit, unit)

    @property
    def border(self) -> tuple[str, float]:
        """Displayed unit, and the factor from SI to it."""
        return ("deg", 180 / math.pi) if self.unit == "rad" else (self.unit, 1.0)


def free(
    robot: Robot,
    names: Sequence[str],
    *,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    log: Sequence[str] = (),
    start: Mapping[str, float] | None = None,
    prior: Mapping[str, float] | None = None,
    recordings: Mapping[str, float] | None = None,
) -> tuple[Free, ...]:
    """Return the free coefficients that names select, with bounds, scales, starts and priors.

    Names are those of `parameter_names`, `water.drag` being short for the law in use. Without brackets all values of a
    column share one value; `[0]` is one of them, `[1-6]` and `[1+4]` tie several, `[0,1-6,7]` are three and `[*]` one
    for each; names of links and joint groups are indices, too. A name that ends in `=common` is one factor on the
    present values, in place of one value for all. `time_offset` and `cost_factor` belong to the trials.

    bounds: lower and upper by name [SI], a name covering all free coefficients in it; others are those of
    data/published/bounds.toml. log: names in log scale, where a default lower bound of 0 is 1e-4 of the upper one.
    start: by name [SI]; others start from the robot's value (the mean of tied ones). prior: by name, the factor by
    which the robot's value may be off (one standard deviation of the logarithm), which sets log scale.
    recordings: first time offset [s] by recording, each of which has a `time_offset` of its own.
    """
    offsets = recordings or {}
    resolver = Names(robot, tuple(offsets))
    places = [place for name in names for place in resolver.resolve(name.strip(), "free")]
    if not places:
        raise InputError("must name at least one coefficient", key="free", fix="give names such as water.drag")
    taken_members: set[tuple[str, Any]] = set()
    for place in places:
        members = {(place.column, member) for member in place.members}
        if members & taken_members:
            fix = "remove one of the two"
            raise InputError("must be listed only once", key=place.name, value="named twice", fix=fix)
        taken_members |= members

    def by_place(table: Mapping[str, Any], key: str) -> dict[FreeValue, Any]:
        return {place: value for name, value in table.items() for place in resolver.covered(name, places, key)}

    ranges, log_scaled = by_place(bounds or {}, "bounds"), by_place(dict.fromkeys(log), "log")
    starts = {FreeValue("time_offset", name): offset for name, offset in offsets.items()} | by_place(
        start or {}, "start"
    )
    priors = by_place(prior or {}, "prior")
    log_scaled |= {place: None for place in priors if place.column not in NUISANCES}
    frees = [_make_free(robot, place, ranges.get(place), starts.get(place), place in log_scaled) for place in places]
    return tuple(_with_prior(robot, f, place, priors.get(place)) for f, place in zip(frees, places, strict=True))


def to_scale(frees: Sequence[Free], values: Sequence[float] | Array) -> Array:
    """Scale values (n,) [SI] of coefficients: natural logarithm for those in log scale, unchanged for others."""
    return np.array([math.log(v) if f.scale == "log" else v for f, v in zip(frees, values, strict=True)], dtype=float)


def from_scale(frees: Sequence[Free], scaled: Sequence[float] | Array) -> Array:
    """Return the values (n,) [SI] of scaled coefficients; inverse of `to_scale`."""
    return np.array([math.exp(x) if f.scale == "log" else x for f, x in zip(frees, scaled, strict=True)], dtype=float)


def bounds_of(frees: Sequence[Free]) -> tuple[Array, Array]:
    """Return lower and upper bounds (n,) in the scales of the coefficients."""
    return to_scale(frees, [f.lower for f in frees]), to_scale(frees, [f.upper for f in frees])


def prior_rows(frees: Sequence[Free], x: Array) -> tuple[Array, Array]:
    """Return residuals (k,) of the k priors at scaled coefficients x (n,), and their Jacobian (k, n)."""
    with_prior = [k for k, f in enumerate(frees) if f.prior is not None]
    mean, sd = np.log([f.prior for f in frees if f.prior is not None]).reshape(-1, 2).T
    return (x[with_prior] - mean) / sd, np.eye(len(frees))[with_prior] / sd[:, np.newaxis]


def columns(robot: Robot, frees: Sequence[Free], values: Sequence[float] | Array) -> dict[str, list[float]]:
    """Return the columns for `core_model` that values (n,) [SI] of coefficients change; links are rods, m l^2/12."""
    changed: dict[str, list[float]] = {}
    for f, value in zip(frees, values, strict=True):
        if f.column not in NUISANCES:
            column = changed.setdefault(f.column, list(column_of(robot, f.column)))
            for i in f.indices:
                column[i] = float(value) * column[i] if f.common else float(value)
    if _inertia_follows(robot, changed):
        changed["links.inertia"] = [mass * length * length / 12 for mass, length in _mass_and_length(robot, changed)]
    return changed


def point_at(
    robot: Robot, frees: Sequence[Free], values: Sequence[float] | Array, *, slopes: bool, **options: Any
) -> Point:
    """Return the model with values (n,) [SI] of coefficients, with derivatives if `slopes`; options: of `Point`."""
    changed = columns(robot, frees, values)
    springs = {name: changed.pop(name) for name in [*changed] if is_spring(name)}
    return Point(
        robot=with_springs(robot, springs),
        model=core_model(robot, changed),
        columns=changed,
        along=parameter_jacobian(robot, frees, values) if slopes else None,
        count=len(frees),
        **options,
    )


def parameter_jacobian(robot: Robot, frees: Sequence[Free], values: Sequence[float] | Array) -> Array:
    """Return derivatives (parameters, n) of the `parameter_rows` with respect to the scaled coefficients."""
    row_of = parameter_rows(robot)
    matrix = np.zeros((len(row_of), len(frees)))
    for k, (f, value) in enumerate(zip(frees, values, strict=True)):
        if f.column not in NUISANCES:
            for i in f.indices:
                row = row_of[parameter_name(f.column, i if f.index else None)]
                present = float(column_of(robot, f.column)[i]) if f.common else 1.0
                matrix[row, k] = present * (value if f.scale == "log" else 1.0)
    if _inertia_follows(robot, {f.column for f in frees}):
        changed = columns(robot, frees, values)
        for i, (mass, length) in enumerate(_mass_and_length(robot, changed)):
            mass_row, length_row = matrix[row_of[f"links.mass[{i}]"]], matrix[row_of[f"links.length[{i}]"]]
            matrix[row_of[f"links.inertia[{i}]"]] = length * length / 12 * mass_row + mass * length / 6 * length_row
    return matrix


def with_values(robot: Robot, frees: Sequence[Free], values: Sequence[float] | Array) -> Robot:
    """Return the robot with values (n,) [SI] of coefficients; its length and mass grow with those of its links."""
    changed = columns(robot, frees, values)
    if not robot.model_fields_set & {"fit"} and not changed:
        return robot
    document = robot.document()
    document.pop("fit", None)
    document.get("sources", {}).pop("fit", None)
    for column, numbers in changed.items():
        if column != "links.inertia" or "inertia" in robot.links.model_fields_set:
            write_column(document, column, numbers)
    links = document["links"]
    if "links.length" in changed:
        document["body"]["length_m"] = math.fsum(links["length_m"])
    if (total := math.fsum(links["mass_kg"])) > document["body"]["mass_kg"] * (1 + 1e-9):
        document["body"]["mass_kg"] = total
    return parse(document, file=robot.file)


def with_fit(
    robot: Robot,
    frees: Sequence[Free],
    values: Sequence[float] | Array,
    *,
    covariance: Array,
    trials: str,
    seed: int,
    text: str,
    reach: Mapping[str, Any] | None = None,
) -> Robot:
    """Return the robot with fitted values (n,) [SI], their sources, and the table [fit] with the covariance (n, n).

    A common factor of the table is relative to the fitted values: 1, with its relative error.
    """
    document = with_values(robot, frees, values).document()
    sources = document.setdefault("sources", {})
    origin = f"identified from {trials}, see [fit]"
    for column in dict.fromkeys(f.column for f in frees if f.column not in NUISANCES):
        key = file_key(column)
        document.get("uncertainty", {}).pop(key, None)  # the value is no estimate any more
        column_frees = [f for f in frees if f.column == column]
        fitted = {i for f in column_frees for i in f.indices}
        other_source = robot.source(key)
        if len(fitted) < len(column_of(robot, column)) and other_source is not None:
            sources[key] = f"{', '.join(f'[{f.index}]' for f in column_frees)} {origin}; others: {other_source}"
        else:
            sources[key] = origin
    sources["fit"] = text
    unit = np.array([float(value) if f.common and value else 1.0 for f, value in zip(frees, values, strict=True)])
    covariance_unit = np.where([f.scale == "log" for f in frees], 1.0, unit)
    document["fit"] = {
        "text": text,
        "trials": trials,
        "seed": seed,
        "names": [f.name for f in frees],
        "units": [f.unit for f in frees],
        "scale": [f.scale for f in frees],
        "value": (np.asarray(values, dtype=float) / unit).tolist(),
        "lower": [f.lower / float(u) for f, u in zip(frees, unit, strict=True)],
        "upper": [f.upper / float(u) for f, u in zip(frees, unit, strict=True)],
        "covariance": (np.asarray(covariance, dtype=float) / np.outer(covariance_unit, covariance_unit)).tolist(),
        **(reach or {}),
    }
    return parse(document, file=robot.file)


def sample_robots(robot: Robot, count: int, seed: int) -> list[Robot]:
    """Sample robots from the normal distribution in the table [fit], truncated at the bounds."""
    fit = robot.fit
    if fit is None:
        fix = "give a file that `hypertuna identify -o` wrote"
        raise InputError("must have a table [fit] to sample from", file=robot.file, fix=fix)
    for name in fit.names:
        if name.partition("[")[0] not in NUISANCES:
            Names(robot).resolve(name, "fit.names")
    frees = [
        Free(name, lower, upper, value, scale)
        for name, lower, upper, value, scale in zip(fit.names, fit.lower, fit.upper, fit.value, fit.scale, strict=True)
    ]
    lower, upper, mean = (to_scale(frees, values) for values in (fit.lower, fit.upper, fit.value))
    rng = np.random.default_rng(seed)
    samples = truncated_normal(mean, np.array(fit.covariance), lower, upper, count=count, rng=rng)
    return [with_values(robot, frees, from_scale(frees, x)) for x in samples]


def _make_free(
    robot: Robot, place: FreeValue, bounds: tuple[float, float] | None, start: float | None, log: bool
) -> Free:
    """Return a free coefficient with its bounds and start, given or default."""
    column, name = place.column, place.name
    table = _factor_bounds(robot, place) if place.common else bounds_table(column)
    value = table.get("start", 0.0)
    if column not in NUISANCES and not place.common:
        present = column_of(robot, column)
        tied = [present[i] for i in place.members if present[i] is not None]
        if tied:  # the mean, written so that equal values give exactly this value
            value = tied[0] + math.fsum(x - tied[0] for x in tied) / len(tied)
    factor = factor_table(column)
    lower, upper = bounds or (table.get("lower", factor["lower"] * value), table.get("upper", factor["upper"] * value))
    if log and lower == 0 and bounds is None:
        lower = upper * 10.0**-LOG_DECADES
    key, range_text = f"bounds {name}", f"{lower:g} to {upper:g}"
    if not (-MAX_BOUND <= lower < upper <= MAX_BOUND):
        rule = f"must have a lower bound below its upper one, both at most {MAX_BOUND:g} in magnitude"
        raise InputError(rule, key=key, value=range_text, fix="give LOW:HIGH")
    if log and lower <= 0:
        rule, fix = "must have bounds greater than 0 in log scale", "give such bounds, or do not name it in --log"
        raise InputError(rule, key=key, value=range_text, fix=fix)
    if value_of(name) not in (*NUISANCES, *SIGNED):
        NOT_NEGATIVE.check(lower, key, "give 0 or more")
    first_value = float(start) if start is not None else max(value, lower) if log and value <= 0 else value
    if not lower <= first_value <= upper:
        key, fix = f"{'start' if start is not None else 'bounds'} {name}", "give other bounds, or another start"
        raise InputError(f"must start within its bounds, {range_text}", key=key, value=f"{first_value:g}", fix=fix)
    made = Free(name, float(lower), float(upper), first_value, "log" if log else "natural")
    if is_spring(column):
        _check_springs(robot, made, key)
    return made


def _check_springs(robot: Robot, one: Free, key: str) -> None:
    """Check that the robot's file is valid with a spring's number at both bounds; key: names the bounds in errors."""
    for end in (one.lower, one.upper):
        try:
            with_values(robot, (one,), (end,))
        except InputError as error:
            rule = f"must keep the robot's file valid (at {end:g} {error.key or ''} {error.rule})"
            value = f"{one.lower:g} to {one.upper:g}"
            raise InputError(rule, key=key, value=value, fix=error.fix or "narrow the bounds") from None


def _with_prior(robot: Robot, coefficient: Free, place: FreeValue, width: float | None) -> Free:
    """Add a prior about the robot's value to a coefficient; width: factor by which the value may be off."""
    if width is None:
        return coefficient
    key = f"prior {coefficient.name}"
    ABOVE_ONE.check(width, key, "give a factor such as 2")
    if place.column in NUISANCES:
        rule = "belongs to the trials, not to the robot, and cannot have a prior"
        raise InputError(rule, key=key, fix="leave it out")
    present = column_of(robot, place.column)
    mean = 1.0 if place.common else float(np.mean([present[i] for i in place.members]))
    if mean <= 0:
        raise InputError(
            "needs a value above 0 in the robot to have a prior", key=key, value=f"{mean:g}", fix="leave it out"
        )
    return replace(coefficient, prior=(mean, width))


def _factor_bounds(robot: Robot, place: FreeValue) -> dict[str, float]:
    """Return bounds and start of a common factor, such that no value leaves the default bounds of its column."""
    present = [float(column_of(robot, place.column)[i]) for i in place.members]
    if not any(present):
        fix = f"write {place.name.removesuffix(COMMON)}: one value for all"
        raise InputError(
            "needs a value other than 0 in the robot to have a common factor", key=place.name, value="0", fix=fix
        )
    table = bounds_table(place.column)
    if not table:
        factor_bounds = factor_table(place.column)
        return {"lower": factor_bounds["lower"], "upper": factor_bounds["upper"], "start": 1.0}
    largest = max(abs(value) for value in present)
    return {"lower": max(0.0, table["lower"] / largest), "upper": max(table["upper"] / largest, 2.0), "start": 1.0}


def _mass_and_length(robot: Robot, changed: Mapping[str, Sequence[float]]) -> Iterator[tuple[float, float]]:
    """Yield mass [kg] and length [m] of each link, with changed columns."""
    mass, length = (changed.get(f"links.{name}", getattr(robot.links, name)) for name in ("mass", "length"))
    return zip(mass, length, strict=True)


def _inertia_follows(robot: Robot, changed: Collection[str]) -> bool:
    """Return whether moments of inertia change, since they follow from masses or lengths that change."""
    follows = "inertia" not in robot.links.model_fields_set and "links.inertia" not in changed
    return follows and bool({"links.mass", "links.length"} & set(changed))
