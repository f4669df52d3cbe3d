"""Sentences on a fit: how far the data constrain each direction, and warnings."""

import math
from collections.abc import Sequence

import numpy as np

from hypertuna.arrays import Array
from hypertuna.identification.coefficients import ABSOLUTE_UNITS, Free
from hypertuna.identification.columns import column_of
from hypertuna.identification.estimator import MIN_SINGULAR, Direction
from hypertuna.identification.experiment import LARGE_ERROR, NAMES, Experiment
from hypertuna.identification.names import NUISANCES
from hypertuna.identification.prediction import Prediction
from hypertuna.trials.kinds import QUANTITIES
from hypertuna.trials.trials import Trials

MIN_WEIGHT = 0.35  # fraction of a direction's largest entry, below which a coefficient is not named
MIN_WEIGHT_UNIDENTIFIABLE = 0.05  # such a fraction for an unidentifiable direction
RELATIVE_NOISE = 0.02  # assumed noise of a measurement that could be added
TIE_TOLERANCE = 1e-6  # relative difference up to which the robot's values of tied parameters are equal
LARGE_SCALE = 1.5  # ratio of residuals to the stated noise above which the user is warned
HELD_RATIO = 0.7  # ratio of a fitted to the prior's standard deviation, above which the prior dominates
MAX_NAMED = 5  # largest number of runs named in a warning


def helpful_measurements(
    data: Experiment, prediction: Prediction, jacobian: Array, unit: Array, quantile: float, directions: list[Direction]
) -> list[str]:
    """Return for each direction a text on a measurement of the same runs that would constrain it, or ""."""
    texts = [""] * len(directions)
    for name, (value, derivatives) in prediction.measurable.items():
        if (data.kind == NAMES.index(name)).sum() == len(value):
            continue
        usable = np.isfinite(value) & (value != 0)
        added_rows = derivatives[usable] * unit / (RELATIVE_NOISE * np.abs(value[usable]))[:, np.newaxis]
        _, singular, vectors = np.linalg.svd(np.concatenate([jacobian, added_rows]), full_matrices=False)
        positive = np.maximum(singular, MIN_SINGULAR * max(float(singular[0]), 1.0))
        for k, d in enumerate(directions):
            sd = math.sqrt(float(np.sum((vectors @ d.vector / positive) ** 2)))
            if not d.constrained and not texts[k] and 2 * quantile * sd < 1:
                percent = f"{100 * RELATIVE_NOISE:g} %"
                texts[k] = f"the {QUANTITIES[name].source} of the same runs, known to {percent}, would constrain them"
    return texts


def direction_sentence(
    data: Experiment, unit: Array, direction: Direction, constrained: Sequence[bool], quantile: float, helpful: str
) -> str:
    """Return a sentence on how far the data constrain a direction."""
    frees = data.free
    weights = np.abs(direction.vector)
    order = [int(i) for i in np.argsort(-weights, kind="stable")]
    source = " and ".join(dict.fromkeys(QUANTITIES[NAMES[k]].source for k in np.unique(data.kind)))
    if direction.constrained:
        named = [i for i in order if weights[i] > MIN_WEIGHT * weights[order[0]]]
        if len(frees) == 1 or (len(named) == 1 and constrained[named[0]]):
            subject = frees[named[0]].name
        else:  # a combination is constrained, but none of its coefficients alone
            subject = f"a combination of {_join([frees[i].name for i in (named if len(named) > 1 else order[:2])])}"
        verb = "constrain" if " and " in source or source.endswith("s") else "constrains"
        precision, first = quantile * direction.sd, frees[named[0]]
        if subject == first.name and first.column in ABSOLUTE_UNITS and first.scale == "natural":
            name, factor = first.border
            return f"{source.capitalize()} {verb} {subject} to {factor * precision * unit[named[0]]:.2g} {name}."
        return f"{source.capitalize()} {verb} {subject} to {100 * precision:.2g} %."
    # name coefficients that move by at least their unit within the direction's interval, or else all with some weight
    moved = 2 * quantile * weights * direction.sd > 1
    named = [i for i in order if moved[i] and weights[i] > MIN_WEIGHT_UNIDENTIFIABLE * weights[order[0]]]
    named = named or [i for i in order if weights[i] > MIN_WEIGHT * weights[order[0]]]
    kinds = data.trials.kinds
    transients = "" if any(kind.transient for kind in kinds) else ", or recordings of transients,"
    other_runs = f"other {' or '.join(kind.others for kind in kinds)}{transients} may"
    remedy = f"; {helpful or other_runs}"
    if len(named) == 1:
        return f"{frees[named[0]].name} is not constrained by {source} alone{remedy.replace('them', 'it')}."
    return f"{_join([frees[i].name for i in named])} cannot be distinguished from {source} alone{remedy}."


def warnings_of(
    data: Experiment,
    values: Array,
    bound: Sequence[str | None],
    directions: Sequence[Direction],
    residual_scale: float,
    prediction: Prediction,
) -> list[str]:
    """Return warnings on fitted values (n,): ties, bounds, unsettled runs, large residuals, open directions."""
    warnings, frees = [], data.free
    for f in frees:
        if f.column not in NUISANCES and not f.common:
            present = np.array(column_of(data.robot, f.column), dtype=float)[list(f.indices)]
            if np.ptp(present) > TIE_TOLERANCE * np.abs(present).max():
                range_text = f"{_with_unit(present.min(), f)} to {_with_unit(present.max(), f)}"
                warnings.append(f"{f.name} is one value in place of several, {range_text}.")
    for f, value, side in zip(frees, values, bound, strict=True):
        if side:
            warnings.append(f"{f.name} is on its {side} bound, {_with_unit(value, f)}: the optimum lies beyond it.")
    if data.without_intervals:
        samples, count = len(data.kind), len(frees)
        coefficients = f"There {'is' if count == 1 else 'are'} {count} free coefficient{'s' * (count != 1)}"
        numbers = f"{coefficients} and {samples} independent measurement{'s' * (samples > 1)}"
        consequence = "the runs can be met exactly, and neither noise nor intervals can be estimated"
        priors = ". Intervals are those of the priors" if any(f.prior for f in frees) else ""
        warnings.append(f"{numbers}: {consequence}{priors}.")
    states = (prediction.failed, "have no settled beat"), (prediction.unstable, "are periodic but unstable")
    for flags, state in states:
        if flags.any():
            names = [data.trials.runs[k] for k in np.flatnonzero(flags)]
            more_names = f" and {len(names) - MAX_NAMED} more" if len(names) > MAX_NAMED else ""
            warnings.append(f"With the fitted values these runs {state}: {', '.join(names[:MAX_NAMED])}{more_names}.")
    if residual_scale > LARGE_SCALE and not data.unknown_kinds:
        warnings.append(
            f"Residuals are {residual_scale:.2g} times the stated noise: the model cannot meet all runs "
            "with these coefficients, or the noise is understated. The intervals include this."
        )
    if not all(d.constrained for d in directions):
        warnings.append("The runs leave some coefficients unidentifiable: see the directions that are not constrained.")
    return warnings


def large_errors(data: Experiment, prediction: Prediction) -> list[str]:
    """Return texts on large training errors, with their quantity; a track's error is relative to its distance."""
    kinds, texts = data.kind[data.sample], []
    error, size = prediction.computed - data.measured, np.abs(data.measured)
    groups: dict[tuple[str, bool], list[int]] = {}
    for k, quantity in enumerate(QUANTITIES.values()):
        if quantity.relative or quantity.path:
            groups.setdefault((quantity.path or quantity.label, quantity.relative), []).append(k)
    for (name, relative), members in groups.items():
        selected = np.isin(kinds, members) & ((size > 0) | (not relative))
        scale = size[selected] if relative or not selected.any() else np.sqrt(np.mean(size[selected] ** 2))
        rms = float(np.sqrt(np.mean((error[selected] / scale) ** 2))) if selected.any() else 0.0
        if rms > LARGE_ERROR:
            texts.append(f"{100 * rms:.0f} % in {name}")
    return texts


def unmet(large: str) -> str:
    """Return sentences that explain a large training error."""
    return (
        f"The training error is {large}: the model does not describe these runs, and neither values nor intervals "
        "can be trusted. Check units, gaits and the robot's shape, free other coefficients, or try another water law."
    )


def held_by_priors(frees: Sequence[Free], sd: Array) -> list[str]:
    """Return warnings on coefficients whose scaled standard deviations (n,) are nearly those of their priors."""
    held = [
        f
        for f, own_sd in zip(frees, sd.tolist(), strict=True)
        if f.prior and own_sd > HELD_RATIO * math.log(f.prior[1])
    ]
    return [
        f"{f.name} is held by its prior, the robot's value within a factor of {f.prior[1]:g}: "
        "the runs say less about it."
        for f in held
        if f.prior
    ]


def repeated_motions(training: Trials, validation: Trials) -> list[str]:
    """Return warnings if validation runs repeat motions of the training runs."""
    pairs = ((kind, fitted, validation.kinds.get(kind, ())) for kind, fitted in training.kinds.items())
    return [text for kind, fitted, held_out in pairs for text in kind.repeated(fitted, held_out)]


def _with_unit(value: float, coefficient: Free) -> str:
    """Format a value with its unit; angles in degrees."""
    unit, factor = coefficient.border
    return f"{value * factor:.4g} {unit}".removesuffix(" 1")


def _join(names: Sequence[str]) -> str:
    """Join names: a, b and c."""
    return " and ".join(", ".join(names).rsplit(", ", 1))
