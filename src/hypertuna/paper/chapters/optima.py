"""Table IV and Fig. 13: optimal gaits, by particle swarm and by gradients, beside the paper's."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeAlias

import numpy as np

from hypertuna.optimization.optimize import Optimum, optimize
from hypertuna.paper.computed import OURS, PAPER, WISHES, Trial
from hypertuna.paper.ledger import RULES, Finding
from hypertuna.reports.html import WIDTH, Picture, Section, Table
from hypertuna.swimming.gait import Gait
from hypertuna.swimming.swim import swim

__all__ = ["Optima", "findings", "gait_table", "method_table", "sections", "seek"]

# By model, expected speed of Table IV and method.
Optima: TypeAlias = Mapping[tuple[str, str, str], Optimum]

METHODS = ("pso", "gradient")
NAMES = {"pso": "particle swarm", "gradient": "gradient"}
BOUNDED = {"frequency_hz", "amplitude_I_deg", "amplitude_II_deg"}
(RULE,) = [rule for rule in RULES if rule.ids == "optimum/max/phase"]
COSTS = WISHES[:3]  # wishes whose costs of transport the paper compares


def seek(trials: Mapping[str, Trial], progress: Callable[[], None] | None = None) -> Optima:
    """Find the best gait for each of the paper's four wishes, under its model and ours.

    Parameters
    ----------
    trials : mapping of str to Trial
    progress : callable, optional
        Called after each model.

    Returns
    -------
    Optima
    """
    found: dict[tuple[str, str, str], Optimum] = {}
    for model in (PAPER, OURS):
        for wish in WISHES:
            wished: dict[str, Any] = {"maximize": "speed"} if wish == "max" else {"speed": float(wish)}
            for method in METHODS:
                found[model, wish, method] = optimize(trials[model].robot, **wished, method=method)
        if progress is not None:
            progress()
    return found


def findings(optima: Optima) -> Iterator[Finding]:
    """Yield where the optima lie: those of the gradient, the swarm's in the note.

    Parameters
    ----------
    optima : Optima

    Yields
    ------
    Finding
    """
    for model in (PAPER, OURS):
        for wish in WISHES:
            ours, swarm = (_numbers(optima[model, wish, method].gait) for method in ("gradient", "pso"))
            for key, value in ours.items():
                yield Finding(f"optimum/{wish}/{key}", model, value, f"the particle swarm ends at {swarm[key]:.4g}")


def sections(optima: Optima, trials: Mapping[str, Trial], paper: Mapping[str, Any]) -> list[Section]:
    """Show Table IV and Fig. 13.

    Parameters
    ----------
    optima : Optima
    trials : mapping of str to Trial
    paper : mapping

    Returns
    -------
    list of Section
    """
    return [
        Section(
            "Optimal gaits, Table IV and Fig. 13",
            [
                _text(optima, trials, paper),
                _fitness(optima),
                _changes(optima, trials, paper),
                gait_table(optima, trials),
                method_table(optima),
            ],
        )
    ]


def _numbers(gait: Gait | None) -> dict[str, float]:
    """Return a gait in the paper's numbers: amplitudes and phase in degrees, frequency in Hz."""
    if gait is None:
        return dict.fromkeys(("amplitude-I", "amplitude-II", "frequency", "phase"), np.nan)
    one, two = np.degrees(gait.amplitude)
    lag = np.degrees(gait.phase[1] - gait.phase[0])
    return {"amplitude-I": float(one), "amplitude-II": float(two), "frequency": gait.frequency, "phase": float(lag)}


def _text(optima: Optima, trials: Mapping[str, Trial], paper: Mapping[str, Any]) -> str:
    """Say what the optima are."""
    best, before = optima[OURS, "max", "gradient"], trials[OURS].gaits["unoptimised-max"]
    told = trials[OURS].gaits["optimised-max"]
    published = paper["values"]["optimum/max/phase"]["value"]
    gaps = {model: _worst(optima, model) for model in (PAPER, OURS)}
    return f"""The authors let a particle swarm of 15 particles and 60 iterations look for gaits within the bounds of
Eq. 41: once for the highest speed, three times for an expected speed at low cost (Eq. 42, whose weight k is not
published; {_weight(optima):g} m/s per J/(kg m) here). Here are the same four wishes by the same kind of swarm and by
gradient ascents with exact derivatives, which agree to
{gaps[PAPER]:.1g} m/s in the fitness with ideal joints, and to {gaps[OURS]:.1g} m/s with joint bandwidth.

{_fastest(optima, published)} The published gait is
{100 * (1 - told.speed / best.speed):.2f} % slower than ours with joint bandwidth, and the unoptimized one
{100 * (1 - before.speed / best.speed):.2f} %. So the model does not confirm the measured gain of
{paper["values"]["speed/change-max"]["value"]:g} %, whose two speeds are of two runs.

**The cheapest gaits at an expected speed are not those of Table IV.** The model prefers {_preference(optima)}."""


def _fastest(optima: Optima, published: float) -> str:
    """Say where the fastest gaits lie, and how little speed tells of the phase."""
    best = {model: optima[model, "max", "gradient"] for model in (PAPER, OURS)}
    phases = {model: _numbers(one.gait)["phase"] for model, one in best.items()}
    near = [model for model, phase in phases.items() if RULE.holds(published, phase)]
    full = all(set(one.bounds) >= BOUNDED for one in best.values())
    which = {0: "with neither joint model", 1: f"only with {near[0] if near else ''}", 2: "with either joint model"}
    lost = {model: 100 * (1 - _speed_at(one, published) / one.speed) for model, one in best.items()}
    both = " and ".join(f"{phase:.1f} deg with {model}" for model, phase in phases.items())
    slower = " and ".join(f"{part:.2f} % with {model}" for model, part in lost.items())
    ends = "on their bounds, as in Table IV" if full else "not all on their bounds, unlike in Table IV"
    return f"""**The fastest gait has both amplitudes and the frequency {ends}; its phase difference is within
{RULE.tolerance:g} deg of the published one {which[len(near)]}**: {both}, where {published:g} deg is published. Speed
hardly tells the phase: at the published one the gait is slower by {slower}."""


def _speed_at(best: Optimum, phase: float) -> float:
    """Return the speed of an optimal gait with another phase difference [deg]."""
    assert best.gait is not None
    return swim(best.robot, replace(best.gait, phase=(0.0, math.radians(phase)))).speed


def _weight(optima: Optima) -> float:
    """Return k of Eq. 42."""
    return optima[OURS, COSTS[0], "gradient"].objective.terms[0][1]


def _worst(optima: Optima, model: str) -> float:
    """Return the largest difference of the two methods in the fitness [m/s]."""
    return max(abs(optima[model, wish, "pso"].value - optima[model, wish, "gradient"].value) for wish in WISHES)


def _preference(optima: Optima) -> str:
    """Say what the cheapest gaits with joint bandwidth look like."""
    gaits = [_numbers(optima[OURS, wish, "gradient"].gait) for wish in COSTS]
    span = {key: _span([gait[key] for gait in gaits]) for key in gaits[0]}
    return (
        f"amplitudes of {span['amplitude-I']} and {span['amplitude-II']} deg at {span['frequency']} Hz with phase "
        f"differences of {span['phase']} deg"
    )


def _span(values: Sequence[float]) -> str:
    """Write the least and the largest of some values."""
    low, high = (f"{value:.3g}" for value in (min(values), max(values)))
    return low if low == high else f"{low} to {high}"


def _fitness(optima: Optima) -> Picture:
    """Draw Fig. 13(a)."""
    from hypertuna.paper.figures import plot_descent

    curves = {}
    for wish in WISHES:
        swarm, best = optima[OURS, wish, "pso"], optima[OURS, wish, "gradient"]
        curves["maximum" if wish == "max" else f"{wish} m/s"] = swarm.history - min(best.value, swarm.value)
    return Picture(
        "fig13a",
        plot_descent(curves, "fitness above the optimum [m/s]", width=WIDTH),
        "Fig. 13(a): how far the best particle of the swarm is above the optimum after each iteration, for the four "
        "wishes. For the highest speed sixty iterations are enough; at an expected speed the swarm stops up to "
        f"{_worst(optima, OURS):.1g} m/s short. The paper's curves have no numbers to compare.",
        "Particle swarm of 15 x 60 with joint bandwidth; the optimum is that of the gradient ascents, and curves end "
        "1e-7 m/s from it.",
    )


def _changes(optima: Optima, trials: Mapping[str, Trial], paper: Mapping[str, Any]) -> Picture:
    """Draw Fig. 13(b)."""
    from hypertuna.paper.figures import plot_changes

    values = paper["values"]
    published = [
        values["speed/change-max"]["value"],
        *(values[f"cost-of-transport/change-{w}"]["value"] for w in COSTS),
    ]
    bars = {"published": published}
    for model in (PAPER, OURS):
        bars[f"authors' gaits, {model}"] = _change(
            trials[model], {w: trials[model].gaits[f"optimised-{w}"] for w in WISHES}
        )
    ours = {wish: optima[OURS, wish, "gradient"].swim for wish in WISHES}
    bars[f"our gaits, {OURS}"] = _change(trials[OURS], ours)
    return Picture(
        "fig13b",
        plot_changes(["speed,\nmaximum", *(f"cost at\n{w} m/s" for w in COSTS)], bars, width=WIDTH),
        "Fig. 13(b): change from the unoptimized to the optimized gaits, as measured by the authors, of their gaits "
        "in the two models, and of our optima. Less cost is better; only at 0.3 m/s do model and measurement agree "
        "on their gaits.",
        "Mechanical cost of settled beats over that of the unoptimized gait in the same model, whose speed is not "
        "exactly the expected one; published costs are electrical.",
    )


def _change(trial: Trial, after: Mapping[str, Any]) -> list[float]:
    """Return changes in percent: of the highest speed, and of the costs at the expected ones."""
    before = {wish: trial.gaits[f"unoptimised-{wish}"] for wish in WISHES}
    speed = after["max"].speed / before["max"].speed
    costs = [after[wish].cost_of_transport / before[wish].cost_of_transport for wish in COSTS]
    return [100 * (ratio - 1) for ratio in (speed, *costs)]


def gait_table(optima: Optima, trials: Mapping[str, Trial]) -> Table:
    """Write Table IV, with what the gaits do in the models.

    Parameters
    ----------
    optima : Optima
    trials : mapping of str to Trial

    Returns
    -------
    Table
    """
    rows: list[list[str | float]] = []
    for wish in WISHES:
        told = "maximum" if wish == "max" else f"at\N{NO-BREAK SPACE}{wish} m/s"
        for kind in ("unoptimised", "optimised"):
            swims = [trials[model].gaits[f"{kind}-{wish}"] for model in (PAPER, OURS)]
            cells = [cell for swim in swims for cell in (f"{swim.speed:.3f}", f"{swim.cost_of_transport:.3g}")]
            rows.append([told, f"published, {kind.replace('mis', 'miz')}", *_cells(swims[0].gait), *cells])
        for model in (PAPER, OURS):
            best = optima[model, wish, "gradient"]
            cells = [f"{best.speed:.3f}", f"{best.cost_of_transport:.3g}"]
            both = [*cells, "", ""] if model == PAPER else ["", "", *cells]
            rows.append([told, f"ours, {model}", *_cells(best.gait), *both])
    angles = ["A I [deg]", "A II [deg]", "f [Hz]", "phase [deg]"]
    models = [f"{model}: {what}" for model in (PAPER, OURS) for what in ("speed [m/s]", "cost [J/(kg m)]")]
    return Table(
        ["wish", "gait", *angles, *models],
        rows,
        "Table IV: gaits as published and as optimal in each model, with their speed and mechanical cost of "
        "transport in the models.",
        "Settled beats; ours by gradient ascents within Eq. 41.",
    )


def _cells(gait: Gait | None) -> list[str]:
    """Write a gait as Table IV does."""
    return [f"{value:.4g}" for value in _numbers(gait).values()]


def method_table(optima: Optima) -> Table:
    """Compare the two methods.

    Parameters
    ----------
    optima : Optima

    Returns
    -------
    Table
    """
    rows: list[list[str | float]] = []
    for model in (PAPER, OURS):
        for wish in WISHES:
            swarm, best = optima[model, wish, "pso"], optima[model, wish, "gradient"]
            fitness = [f"{sign * o.value:.5f}" for sign in [-1 if wish == "max" else 1] for o in (swarm, best)]
            phases = [f"{_numbers(o.gait)['phase']:.1f}" for o in (swarm, best)]
            told = "maximum" if wish == "max" else f"at\N{NO-BREAK SPACE}{wish} m/s"
            rows.append([model, told, *fitness, *phases, str(swarm.evaluations), str(best.evaluations)])
    pairs = [f"{what}, {NAMES[m]}" for what in ("fitness [m/s]", "phase [deg]", "gaits swum") for m in METHODS]
    return Table(
        ["model", "wish", *pairs],
        rows,
        "What the two methods end at: the highest speed, or the fitness of Eq. 42; the phase difference there; and how "
        "many gaits they swim.",
        "`hypertuna optimize --maximize speed` or `--speed 0.4`, with `--method pso` or `gradient`.",
    )
