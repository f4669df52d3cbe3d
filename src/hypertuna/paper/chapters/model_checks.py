"""Fig. 12: how the identification converges, and checks of what the model predicts."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from hypertuna.arrays import Array
from hypertuna.identification.identify import Fit
from hypertuna.metrics import cost_of_transport
from hypertuna.paper.chapter import Trials, compose
from hypertuna.paper.computed import OURS, PAPER, SPEEDS, Trial
from hypertuna.paper.ledger import Finding, published, published_value
from hypertuna.reports.html import Section
from hypertuna.swimming.swim import swim

COST = "cost-of-transport/minimum"


def model_checks(fits: Mapping[str, Fit], trials: Trials) -> list[Section]:
    """Show Fig. 12, from the fits of the nine coefficients by model."""
    from hypertuna.paper.figures import plot_against, plot_normalized, plot_paths, plot_start

    fit, from_rest, lake = next(iter(fits.values())), trials[OURS].start, published()["lake"]
    lake_cost = cost_of_transport(lake["energy_wh"] * 3600 / lake["distance_m"], trials[OURS].robot.body.mass, 1.0)
    truth = [published_value(f"speed/{name}") for name in SPEEDS]
    points = [
        (trials[OURS].robot.gaits["unoptimised-max"].frequency, 1.0, "tank"),
        (trials[OURS].robot.gaits["optimised-0.5"].frequency, float(lake_cost) / published_value(COST), "lake"),
    ]
    figures = {
        "fig12a": plot_paths(*_paths(fits)),
        "fig12b": plot_against(truth, _speeds(fits, trials)),
        "fig12c": plot_start({model: trials[model].start for model in (PAPER, OURS)}),
        "fig12d": plot_normalized(published()["tank"]["frequency_hz"], _costs(trials), points),
    }
    return compose(
        "model_checks",
        figures,
        bound=published_value("speed/model-error-max"),
        start="the paper's start values" if len(fit.costs) == 1 else "the best of several starts",
        rounds=" and ".join(f"{len(fit.path) - 1} with {model}" for model, fit in fits.items()),
        published_rounds=published()["identification"]["rounds"],
        rest=from_rest,
        angles=",".join(f"{angle:g}" for angle in np.degrees(from_rest.gait.amplitude).round(6)),
        phase=np.degrees(from_rest.gait.phase[-1]),
        cost=published_value(COST),
        lake=lake,
        lake_cost=float(lake_cost),
    )


def start_finding(model: str, trial: Trial) -> Finding:
    """Return the mean speed over the last half of a swim from rest through the tank, relative to the settled speed."""
    swim, facts = trial.start, published()["start"]
    motion, length = swim.trajectory, trial.robot.body.length
    distance = np.hypot(motion.x - motion.x[0], motion.y - motion.y[0]).values
    end = min(int(np.searchsorted(distance, facts["tank_m"] - length)), len(distance) - 1)
    middle = end // 2
    speed = float(motion.forward_speed[middle:end].mean())
    point = {"frequency": facts["frequency_hz"], "phase": np.radians(facts["phase_deg"])}
    tank = trial.tank.speed.isel(bias=0, amplitude=list(published()["tank"]["amplitude_deg"]).index(facts["amplitude"]))
    settled = float(tank.sel(point, method="nearest"))
    seconds, meters = float(motion.time[end]), distance[end]
    note = f"{speed:.3g} of {settled:.3g} m/s in the last half of {seconds:.3g} s, in which it swims {meters:.3g} m"
    return Finding("start/steady", model, "prediction", speed / settled, note)


def _paths(fits: Mapping[str, Fit]) -> tuple[dict[str, Array], list[str]]:
    """Return coefficients over iterations by model, relative to their bounds [1], and the coefficients' names."""
    free = next(iter(fits.values())).free
    low, high = (np.array([getattr(one, side) for one in free]) for side in ("lower", "upper"))
    places = {model: (fit.path - low) / (high - low) for model, fit in fits.items()}
    return places, [one.name.rpartition(".")[2].replace("added_mass", "added mass") for one in free]


def _speeds(fits: Mapping[str, Fit], trials: Trials) -> dict[str, list[float]]:
    """Return the eight speeds by model, as published and refitted [m/s]."""
    speeds = {model: [trials[model].gaits[name].speed for name in SPEEDS] for model in (PAPER, OURS)}
    for model, fit in fits.items():
        speeds[f"{model}, refitted"] = [swim(fit.robot, trials[model].gaits[name].gait).speed for name in SPEEDS]
    return speeds


def _costs(trials: Trials) -> dict[str, Array]:
    """Return by model the cost of transport at each frequency over that at the highest frequency [1]."""
    tank = published()["tank"]
    place: dict[str, Any] = {"amplitude": list(tank["amplitude_deg"]).index("large"), "bias": 0}
    place["phase"] = tank["phase_deg"].index(published_value("optimal-phase/fastest"))
    costs = {model: trials[model].tank.cost_of_transport.isel(place).values for model in (PAPER, OURS)}
    return {model: cost / cost[-1] for model, cost in costs.items()}
