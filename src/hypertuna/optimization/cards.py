"""Cards and tables of optima and Pareto fronts."""

from typing import Any

import numpy as np

from hypertuna.display import Card, Facts, Part, Table, cards, tables
from hypertuna.io.quantity import Quantity
from hypertuna.optimization.design_space import gait_columns
from hypertuna.optimization.optimum import Margin, Optimum
from hypertuna.optimization.pareto import Front
from hypertuna.optimization.problem import STATISTICS
from hypertuna.pictures import curve_svg
from hypertuna.swimming.beat import QUANTITIES
from hypertuna.swimming.cards import picture_of
from hypertuna.swimming.gait import Gait

ROWS = 24  # most points of a front in a table


@cards.of(Optimum)
def optimum_card(result: Optimum) -> Card:
    """Show the best gait swimming, the limits and bounds that it meets, and how the search ended."""
    feasible = result.gait is not None
    parts: list[Part] = []
    if result.gait is not None and result.swim is not None:
        parts.append(Facts(_summary(result, result.gait)))
    parts.append((result.stop, "green" if feasible else "bold red"))
    if result.remark:
        parts.append((result.remark, "" if result.near_best else "yellow"))
    parts.append((f"{result.evaluations} gaits by {result.method}, seed {result.seed}", "dim"))
    picture = None if result.swim is None else picture_of(result.swim)
    return Card(f"{result.robot.name}, {objective_text(result)}", parts, picture)


def objective_text(result: Optimum) -> str:
    """Return the objective of a search in words."""
    target = result.objective
    name, factor = target.terms[0]
    text = f"{'highest' if factor < 0 else 'lowest'} {name.replace('_', ' ')}"
    if target.expected is not None:
        text = f"expected speed {target.expected:g} m/s at low cost of transport, weight {factor:g}"
    return text if result.robust is None else f"{text}, over robots sampled from the fit"


def margin_record(margin: Margin) -> dict[str, Any]:
    """Return a limit, the gait's value and its margin to the limit, for JSON."""
    limit = margin.limit
    return {
        "name": limit.quantity,
        "value": margin.value / limit.scale,
        "limit": limit.limit / limit.scale,
        "unit": limit.unit,
        "kind": "largest" if limit.upper else "least",
        "margin": margin.margin,
        "active": margin.active,
    }


def _summary(result: Optimum, gait: Gait) -> dict[str, Quantity]:
    """Return by label: the values of the gait with the bounds that they lie on, speed and cost, and limits."""
    summary = {}
    for (column, size), value in zip(gait_columns(result.robot).items(), gait.values, strict=True):
        label, _, unit = column.replace("_", " ").rpartition(" ")
        if any(gait.bias) or not column.startswith("bias"):
            bound = f" ({result.bounds[column]} bound)" if column in result.bounds else ""
            summary[label] = (value / size, ("Hz" if unit == "hz" else unit) + bound)
    for variable in result.variables:
        bound = f" ({result.bounds[variable.name]} bound)" if variable.name in result.bounds else ""
        summary[variable.label] = (result.design[variable.name], variable.unit + bound)
    summary["speed"] = (result.speed, "m/s")
    summary["cost of transport"] = (result.cost_of_transport, "J/(kg m)")
    if result.robust is not None:  # the values above are of the robot itself
        name, factor = result.objective.terms[0]
        value, unit = factor * result.value, QUANTITIES[name].unit
        if result.objective.expected is not None:
            name, value, unit = "|U - Ue| + k COT", result.value, "m/s"
        summary[f"{name.replace('_', ' ')}, sampled robots"] = (value, f"{unit}, {STATISTICS[result.robust]}")
    for margin in map(margin_record, result.margins):
        unit = margin["unit"].removeprefix("1")
        side = "at least" if margin["kind"] == "least" else "at most"
        limit = f"({side} {margin['limit']:g}{', active' * margin['active']})"
        summary[margin["name"].replace("_", " ")] = (margin["value"], f"{unit} {limit}".strip())
    return {label: Quantity(value, unit, label) for label, (value, unit) in summary.items()}


@tables.of(Optimum)
def optimum_columns(result: Optimum) -> dict[str, Any]:
    """Return as columns the number of gaits swum and the best value so far, with the quantity's own sign."""
    name, factor = result.objective.terms[0]
    if result.objective.expected is not None:
        name, factor = "objective", 1.0
    return {"gaits_swum": result.swum, f"best_{name}": np.sign(factor) * result.history}


@cards.of(Front)
def front_card(front: Front) -> Card:
    """Show up to `ROWS` points of a front, its hypervolume, and how the search ended."""
    count = len(front.x)
    if not count:
        return Card(f"{front.robot.name}: no best compromise", [(front.stop, "bold red")])
    heads = [f"{name.replace('_', ' ')}\n[{unit}]" for name, unit in zip(front.objectives, front.units, strict=True)]
    design = [(variable.label, front.designs[variable.name]) for variable in front.space.variables]
    heads += [label.replace(".", "\n", 1) for label, _ in design]
    rows = []
    for k in np.unique(np.linspace(0, count - 1, min(count, ROWS)).round().astype(int)):
        gait = front.gaits[k]
        angles = (", ".join(f"{angle:.4g}" for angle in np.degrees(values)) for values in (gait.amplitude, gait.phase))
        values = [*front.values[k], *(column[k] for _, column in design)]
        rows.append((*(f"{value:.4g}" for value in values), f"{gait.frequency:.3g}", *angles))
    robust = f", {STATISTICS[front.robust]}" if front.robust else ""
    reference = ", ".join(f"{value:.4g}" for value in front.reference)
    parts: list[Part] = [Table([*heads, "f\n[Hz]", "amplitude\n[deg]", "phase\n[deg]"], rows, left=())]
    parts.append(f"hypervolume {front.hypervolume:.5g} [{' '.join(front.units)}] from the reference point {reference}")
    if front.polished:
        residual = np.median(front.stationarity)
        parts.append(f"before polishing {front.hypervolume_evolved:.5g}; median stationarity {residual:.1e}")
    parts.append((front.stop, "green"))
    label, x, y = " over ".join(head.replace("\n", " ") for head in heads[1::-1]), *front.values[:, :2].T
    picture = (lambda: curve_svg(x, y, label, dots=True)) if count > 1 else None
    return Card(f"{front.robot.name}: {count} best compromises{robust}", parts, picture)
