"""The tank tests of section III.D: best phase differences, trends, maps of Fig. 10."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from hypertuna.arrays import Array
from hypertuna.paper.chapter import Chapter, Trials, compose
from hypertuna.paper.computed import LEVELS, OURS, PAPER, TANK, Trial
from hypertuna.paper.ledger import Class, Finding, published, published_value
from hypertuna.paper.studies import PHASES
from hypertuna.reports.html import Section

if TYPE_CHECKING:
    import xarray as xr

FREQUENCY, PHASE = "cost-of-transport/cheapest-hz", "cost-of-transport/cheapest-phase"
# Table II was interpreted so that ideal joints have the published best phases (docs/paper.md).
IN_SIGHT: Class = "in sight"
AHEAD = f"phases up to {PHASES[-1]:g} deg"
FLAT = 1e-3  # a step in frequency slows the rise if it rises less than the last step by this fraction


def findings(trials: Trials) -> Iterator[Finding]:
    """Yield best phase differences, where swimming is cheapest, and trends over frequency and amplitude."""
    for model, trial in trials.items():
        yield from tank_findings(model, trial)


def tank_findings(model: str, trial: Trial) -> Iterator[Finding]:
    """Yield one model's best phase differences, where swimming is cheapest, and trends."""
    hertz = published()["tank"]["frequency_hz"]
    for level in LEVELS:
        yield best_phase(model, level, _grid(trial.tank.speed, level), hertz, IN_SIGHT)
    yield _fastest_phase(model, trial)
    yield from _cheapest(model, trial)
    yield from _trends(model, trial)


def sections(trials: Trials) -> list[Section]:
    """Show the maps of Fig. 10."""
    from hypertuna.paper.figures import plot_map

    levels = {
        f"{level}\n{a:g}°, {b:g}°": published()["values"].get(f"optimal-phase/{level}", {}).get("value")
        for level, (a, b) in published()["tank"]["amplitude_deg"].items()
    }
    tank = trials[OURS].tank
    figures = {
        "fig10-speed": plot_map(tank, "speed", "speed [m/s]", levels),
        "fig10-cost": plot_map(tank, "cost_of_transport", "cost of transport [J/(kg m)]", levels, lowest=True),
    }
    costs = [trials[model].tank.cost_of_transport.isel(bias=0, amplitude=-1, phase=2).values for model in (OURS, PAPER)]
    rise, rise_ideal = (cost[-1] / cost[0] for cost in costs)
    phases, frequencies = published()["tank"]["phase_deg"], published()["tank"]["frequency_hz"]
    return compose("tank", figures, phases=phases, frequencies=frequencies, rise=rise, rise_ideal=rise_ideal)


def _lead(speed: Array) -> float:
    """Return the relative lead of the highest of some speeds over the second."""
    second, best = np.sort(speed)[-2:]
    return float(best / second - 1)


def best_phase(model: str, level: str, speed: Array, hertz: Sequence[float], class_: Class = "prediction") -> Finding:
    """Return the phase that is fastest at most frequencies, from speeds (frequency, phase) [m/s] at one amplitude."""
    tank = published()["tank"]
    best = [float(tank["phase_deg"][k]) for k in speed.argmax(axis=1)]
    commonest = max(reversed(best), key=best.count)  # if two are best equally often, the one at the higher frequency
    rows = zip(hertz, best, speed, strict=True)
    phases = ", ".join(f"{f:g} Hz: {phase:g} deg, by {100 * _lead(row):.1f} %" for f, phase, row in rows)
    return Finding(f"optimal-phase/{level}", model, class_, commonest, f"best, and its lead over the next, at {phases}")


def _fastest_phase(model: str, trial: Trial) -> Finding:
    """Return the phase of the fastest gait of the grid."""
    tank = published()["tank"]
    speed = trial.tank.speed.isel(bias=0).transpose("frequency", "amplitude", "phase").values
    frequency, amplitude, phase = np.unravel_index(speed.argmax(), speed.shape)
    note = (
        f"fastest at {tank['frequency_hz'][frequency]:g} Hz and {list(tank['amplitude_deg'])[amplitude]} amplitude, "
        f"{100 * _lead(speed[frequency, amplitude]):.1f} % ahead of the next phase"
    )
    return Finding("optimal-phase/fastest", model, IN_SIGHT, float(tank["phase_deg"][phase]), note)


def _cheapest(model: str, trial: Trial) -> Iterator[Finding]:
    """Yield frequency and phase of the least mechanical cost at the amplitude of the paper's cheapest gait."""
    tank = published()["tank"]
    cost = _grid(trial.tank.cost_of_transport, TANK)
    row, column = (
        tank["frequency_hz"].index(published_value(FREQUENCY)),
        tank["phase_deg"].index(published_value(PHASE)),
    )
    note = f"mechanical, {cost[:, column].min():.2g} to {cost[:, column].max():.2g} J/(kg m)"
    yield Finding(FREQUENCY, model, "prediction", tank["frequency_hz"][cost[:, column].argmin()], note)
    note = f"mechanical, {cost[row].min():.2g} to {cost[row].max():.2g} J/(kg m)"
    yield Finding(PHASE, model, "prediction", tank["phase_deg"][cost[row].argmin()], note)


def _trends(model: str, trial: Trial) -> Iterator[Finding]:
    """Yield trends of speed and mechanical cost over frequency and amplitude.

    Speed is proportional to frequency for ideal joints, so that its rise is no finding; joints that lag were introduced
    because the published rise slows down.
    """
    tank = trial.tank.isel(bias=0, phase=slice(len(PHASES))).transpose("frequency", "amplitude", "phase")
    lagging = trial.robot.model.joints == "bandwidth"
    rises, slows = frequency_trends(tank.speed.values).items()
    if lagging:
        yield Finding(rises[0], model, "prediction", rises[1], AHEAD)
    yield Finding(slows[0], model, IN_SIGHT if lagging else "prediction", slows[1], AHEAD)
    speed, power = (np.moveaxis(tank[name].values, 1, 0) for name in ("speed", "mechanical_power"))
    for key, value in amplitude_trends(speed, power).items():
        yield Finding(key, model, "prediction", value, f"{AHEAD}{'; mechanical' if 'cost' in key else ''}")


def frequency_trends(speed: Array) -> dict[str, float]:
    """Return shares [%] of steps in frequency (axis 0) where speed rises, and where it rises less than before."""
    rise = np.diff(speed, axis=0)
    slower = rise[1:] < rise[:-1] - FLAT * np.abs(rise[:-1])
    return {"speed/over-frequency": 100 * float(np.mean(rise > 0)), "speed/slows": 100 * float(np.mean(slower))}


def amplitude_trends(speed: Array, power: Array) -> dict[str, float]:
    """Return shares [%] of steps in amplitude (axis 0) where speed rises, and where cost falls while swimming ahead."""
    cost = power / np.where(speed > 0, speed, np.nan)
    rises, falls = np.diff(speed, axis=0) > 0, np.diff(cost, axis=0) < 0
    keys = ("speed/over-amplitude", "cost-of-transport/over-amplitude")
    return dict(zip(keys, (100 * float(np.mean(part)) for part in (rises, falls)), strict=True))


def _grid(values: xr.DataArray, level: str) -> Array:
    """Return the values of the grid at one amplitude (frequency, phase)."""
    row = list(published()["tank"]["amplitude_deg"]).index(level)
    return np.asarray(values.isel(amplitude=row, bias=0).transpose("frequency", "phase"))


CHAPTER = Chapter("tank", sections, findings)
