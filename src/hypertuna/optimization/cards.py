"""What notebooks and shells show of optima and Pareto fronts."""

from typing import Any

import numpy as np

from hypertuna.display import Card, number
from hypertuna.optimization.optimum import Optimum
from hypertuna.optimization.pareto import Front
from hypertuna.pictures import curve_svg
from hypertuna.swimming.cards import gait_text, picture_of, swim_facts


def objective_text(result: Optimum) -> str:
    """Write the objective of a search."""
    target = result.objective
    name, factor = target.terms[0]
    words = f"{'highest' if factor < 0 else 'lowest'} {name.replace('_', ' ')}"
    if target.expected is not None:
        words = f"expected speed {target.expected:g} m/s at low cost of transport"
    return words if result.robust is None else f"{words}, over robots sampled from the fit"


def optimum_card(result: Optimum) -> Card:
    """Show the best gait swimming, what limits it, and how the search ended."""
    title = f"{result.robot.name}, {objective_text(result)}"
    text = " ".join(filter(None, [result.stop, result.remark]))
    text += f" {result.evaluations} gaits by {result.method}, seed {result.seed}."
    if result.swim is None or result.gait is None:
        return Card(f"{title}: no gait satisfies all limits", (), text)
    ends = [(_with_unit(name), f"on its {side} bound", "") for name, side in result.bounds.items()]
    limits = [
        (
            margin.limit.quantity.replace("_", " "),
            number(margin.value / margin.limit.scale, margin.limit.unit.removeprefix("1")),
            f"{'at most' if margin.limit.upper else 'at least'} {number(margin.limit.limit / margin.limit.scale)}"
            f"{', active' * margin.active}",
        )
        for margin in result.margins
    ]
    facts = swim_facts(result.swim)
    columns = ("bound or limit", "value", "limit")
    return Card(f"{title}: {gait_text(result.gait)}", facts, text, columns, limits + ends, picture_of(result.swim))


def _with_unit(name: str) -> str:
    """Write the name of a gait parameter, such as phase_II_deg, in words: phase II [deg]."""
    quantity, _, unit = name.rpartition("_")
    return f"{quantity.replace('_', ' ')} [{unit.replace('hz', 'Hz')}]"


def optimum_columns(result: Optimum) -> dict[str, Any]:
    """Return the best value after each batch of gaits, with the sign of the quantity."""
    name, factor = result.objective.terms[0]
    if result.objective.expected is not None:
        name, factor = "objective", 1.0
    return {"gaits_swum": result.swum, f"best_{name}": np.sign(factor) * result.history}


def front_card(front: Front) -> Card:
    """Show the best compromises, from one end of the front to the other."""
    count = len(front.x)
    title = f"{front.robot.name}: {count} best compromises of {' and '.join(front.objectives).replace('_', ' ')}"
    facts = [("hypervolume", number(front.hypervolume, " ".join(front.units))), ("gaits swum", f"{front.evaluations}")]
    if front.polished and count:
        facts.append(("median stationarity", f"{np.median(front.stationarity):.1e}"))
    heads = [f"{name.replace('_', ' ')} [{unit}]" for name, unit in zip(front.objectives, front.units, strict=True)]
    rows = [
        (*(number(float(value)) for value in values), gait_text(gait))
        for values, gait in zip(front.values, front.gaits, strict=True)
    ]
    label = f"{heads[1]} over {heads[0]}"
    values = front.values
    picture = (lambda: curve_svg(values[:, 0], values[:, 1], label, dots=True)) if count > 1 else None
    return Card(title, facts, front.stop, (*heads, "gait"), rows, picture)
