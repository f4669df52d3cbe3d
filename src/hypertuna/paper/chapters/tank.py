"""The tank tests of section III.D: best phase differences, maps of Fig. 10."""

from collections.abc import Iterator

import numpy as np

from hypertuna.arrays import Array
from hypertuna.paper.chapter import Chapter, Trials, compose
from hypertuna.paper.computed import OURS, PAPER, Trial
from hypertuna.paper.ledger import Finding, published
from hypertuna.reports.html import Section


def findings(trials: Trials) -> Iterator[Finding]:
    """Yield best phase differences: of each amplitude under the paper's model, and of the fastest gait."""
    for row, level in enumerate(published()["tank"]["amplitude_deg"]):
        if f"optimal-phase/{level}" in published()["values"]:
            yield _optimal_phase(level, row, trials)
    for model, trial in trials.items():
        yield _fastest_phase(model, trial)


def sections(trials: Trials) -> list[Section]:
    """Show the maps of Fig. 10."""
    from hypertuna.paper.figures import plot_map

    levels = {
        f"{level}\n{one:g}°, {two:g}°": published()["values"].get(f"optimal-phase/{level}", {}).get("value")
        for level, (one, two) in published()["tank"]["amplitude_deg"].items()
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
    """Return how far the best of some speeds is ahead of the second, relative to it."""
    second, best = np.sort(speed)[-2:]
    return float(best / second - 1)


def _optimal_phase(level: str, row: int, trials: Trials) -> Finding:
    """Return the best phase at one amplitude: that of most frequencies."""
    tank = published()["tank"]
    speeds = [
        trials[model].tank.speed.isel(amplitude=row, bias=0).transpose("frequency", "phase").values
        for model in (PAPER, OURS)
    ]
    own, other = ([float(tank["phase_deg"][k]) for k in speed.argmax(axis=1)] for speed in speeds)
    best = max(own, key=own.count)
    some = f"at {own.count(best)} of {len(own)} frequencies"
    everywhere = "at every frequency" if own.count(best) == len(own) else some
    bandwidth = " and ".join(
        f"{phase:g} deg at "
        f"{', '.join(f'{f:g}' for f, p in zip(tank['frequency_hz'], other, strict=True) if p == phase)} Hz"
        for phase in sorted(set(other), reverse=True)
    )
    note = f"{everywhere}, {100 * _lead(speeds[0][0]):.1f} % ahead of the next; under joint bandwidth {bandwidth}"
    return Finding(f"optimal-phase/{level}", PAPER, best, note)


def _fastest_phase(model: str, trial: Trial) -> Finding:
    """Return the phase of the fastest gait of the grid."""
    tank = published()["tank"]
    speed = trial.tank.speed.isel(bias=0).transpose("frequency", "amplitude", "phase").values
    frequency, amplitude, phase = np.unravel_index(speed.argmax(), speed.shape)
    note = (
        f"fastest at {tank['frequency_hz'][frequency]:g} Hz and {list(tank['amplitude_deg'])[amplitude]} amplitude, "
        f"{100 * _lead(speed[frequency, amplitude]):.1f} % ahead of the next phase"
    )
    return Finding("optimal-phase/fastest", model, float(tank["phase_deg"][phase]), note)


CHAPTER = Chapter("tank", sections, findings)
