"""The tank tests of section III.D: best phase differences, maps of Fig. 10."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from hypertuna.paper.computed import OURS, PAPER, Trial
from hypertuna.paper.ledger import Finding
from hypertuna.reports.html import WIDTH, Picture, Section

__all__ = ["findings", "sections"]


def findings(trials: Mapping[str, Trial], paper: Mapping[str, Any]) -> Iterator[Finding]:
    """Yield best phase differences: of each amplitude under the paper's model, and of the fastest gait.

    Parameters
    ----------
    trials : mapping of str to Trial
    paper : mapping

    Yields
    ------
    Finding
    """
    for row, level in enumerate(paper["tank"]["amplitude_deg"]):
        if f"optimal-phase/{level}" in paper["values"]:
            yield _optimal_phase(level, row, trials, paper)
    for model, trial in trials.items():
        yield _fastest_phase(model, trial, paper)


def sections(trials: Mapping[str, Trial], paper: Mapping[str, Any]) -> list[Section]:
    """Show the maps of Fig. 10.

    Parameters
    ----------
    trials : mapping of str to Trial
    paper : mapping

    Returns
    -------
    list of Section
    """
    from hypertuna.paper.figures import plot_map

    levels = {
        f"{level}\n{one:g}°, {two:g}°": paper["values"].get(f"optimal-phase/{level}", {}).get("value")
        for level, (one, two) in paper["tank"]["amplitude_deg"].items()
    }
    tank = trials[OURS].tank
    speed = Picture(
        "fig10-speed",
        plot_map(tank, "speed", "speed [m/s]", levels, width=WIDTH),
        "Speed over frequency and phase difference at small, medium and large amplitude of joints I and II: it "
        "rises with frequency and amplitude, and peaks (dots) at phases where the paper found its best ones "
        "(dashed) or 20 deg below.",
        "One settled beat for each cell, with joint bandwidth and Table III.",
    )
    cost = Picture(
        "fig10-cost",
        plot_map(tank, "cost_of_transport", "cost of transport [J/(kg m)]", levels, lowest=True, width=WIDTH),
        "Mechanical cost of transport of the same gaits. It rises with frequency and is least (dots) at the largest "
        "phase, where the robot hardly swims; the paper measured the cost of the servos' electricity, which falls "
        "with frequency.",
        "The joints' mean mechanical power over 3.3 kg and speed (Eq. 39), from the same beats.",
    )
    return [Section("The tank tests, Fig. 10", [_text(trials, paper), speed, cost])]


def _text(trials: Mapping[str, Trial], paper: Mapping[str, Any]) -> str:
    """Say what was swum, and what the paper says of it."""
    phases, frequencies = paper["tank"]["phase_deg"], paper["tank"]["frequency_hz"]
    costs = [trials[model].tank.cost_of_transport.isel(bias=0, amplitude=-1, phase=2).values for model in (OURS, PAPER)]
    rise, rise_ideal = (cost[-1] / cost[0] for cost in costs)
    return f"""Section III.D swims three amplitudes, several frequencies and several phase differences, and shows the
results as pictures without numbers. The text gives the best phase for speed at small and at large amplitude, and the
fastest gait; how far the phases went it does not say. Here they go from {phases[0]:g} to {phases[-1]:g} deg in steps
of {phases[1] - phases[0]:g} deg, at {frequencies[0]:g} to {frequencies[-1]:g} Hz.

Two statements of the paper do not hold in any model of inertia and quadratic drag. **Measured cost of transport falls
with frequency; the computed one rises**, {rise:.0f} times from {frequencies[0]:g} to {frequencies[-1]:g} Hz at large
amplitude and {phases[2]:g} deg, and {rise_ideal:.0f} times with ideal joints, because power then goes with the cube
of frequency and speed with its first power. Pumps and servos must take the difference. And the phase that is best for
speed is not the cheapest one."""


def _best_phases(trial: Trial, paper: Mapping[str, Any], row: int) -> list[float]:
    """Fastest phase at each frequency [deg]."""
    speed = trial.tank.speed.isel(amplitude=row, bias=0).transpose("frequency", "phase").values
    return [float(paper["tank"]["phase_deg"][k]) for k in speed.argmax(axis=1)]


def _lead(speed: Any) -> float:
    """By how much the best of some speeds is ahead of the second."""
    second, best = np.sort(speed)[-2:]
    return float(best / second - 1)


def _optimal_phase(level: str, row: int, trials: Mapping[str, Trial], paper: Mapping[str, Any]) -> Finding:
    """Best phase at one amplitude: that of most frequencies."""
    own, other = (_best_phases(trials[name], paper, row) for name in (PAPER, OURS))
    speed = trials[PAPER].tank.speed.isel(amplitude=row, bias=0).transpose("frequency", "phase").values
    best = max(own, key=own.count)
    everywhere = (
        "at every frequency" if own.count(best) == len(own) else f"at {own.count(best)} of {len(own)} frequencies"
    )
    frequencies = paper["tank"]["frequency_hz"]
    bandwidth = " and ".join(
        f"{phase:g} deg at {', '.join(f'{f:g}' for f, p in zip(frequencies, other, strict=True) if p == phase)} Hz"
        for phase in sorted(set(other), reverse=True)
    )
    note = f"{everywhere}, {100 * _lead(speed[0]):.1f} % ahead of the next; under joint bandwidth {bandwidth}"
    return Finding(f"optimal-phase/{level}", PAPER, best, note)


def _fastest_phase(model: str, trial: Trial, paper: Mapping[str, Any]) -> Finding:
    """Phase of the fastest gait of the grid."""
    speed = trial.tank.speed.isel(bias=0).transpose("frequency", "amplitude", "phase").values
    frequency, amplitude, phase = np.unravel_index(speed.argmax(), speed.shape)
    level = list(paper["tank"]["amplitude_deg"])[amplitude]
    note = (
        f"fastest at {paper['tank']['frequency_hz'][frequency]:g} Hz and {level} amplitude, "
        f"{100 * _lead(speed[frequency, amplitude]):.1f} % ahead of the next phase"
    )
    return Finding("optimal-phase/fastest", model, float(paper["tank"]["phase_deg"][phase]), note)
