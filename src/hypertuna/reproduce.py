"""The ledger: every number of the paper that the model can answer, computed beside published, with a verdict."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from hypertuna.description import Robot, load
from hypertuna.gait import named_gait
from hypertuna.ledger import RULES, VERDICTS, Entry, judge, published
from hypertuna.metrics import cost_of_transport
from hypertuna.results import provenance
from hypertuna.sweep import Gaits, sweep
from hypertuna.swim import Swim, swim

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["OURS", "PAPER", "SPEEDS", "Ledger", "Trial", "ledger_record", "reproduce"]

PAPER = "ideal joints"  # the paper's own model
OURS = "joint bandwidth"  # with our one parameter more
MODELS: dict[str, dict[str, str]] = {PAPER: {"joints": "ideal"}, OURS: {"joints": "bandwidth"}}
AS_PRINTED = {f"{name}, areas as printed": choice | {"areas": "as-printed"} for name, choice in MODELS.items()}
ARITHMETIC = "the paper's own numbers"
SPEEDS = tuple(f"{kind}optimised-{speed}" for kind in ("un", "") for speed in ("0.3", "0.4", "0.5", "max"))


@dataclass(frozen=True)
class Trial:
    """What one model computes: the robot's named gaits, the grid of the paper's tank tests, turning over phases."""

    robot: Robot
    gaits: dict[str, Swim]
    tank: xr.Dataset
    turning: xr.Dataset


@dataclass(frozen=True)
class Ledger:
    """All entries, what they add up to, and the computations behind them by model."""

    entries: tuple[Entry, ...]
    summary: dict[str, Any]
    provenance: dict[str, str]
    trials: dict[str, Trial]


Finding = tuple[str, str, float | None, str]  # id, model, computed, note


def reproduce(*, full: bool = False, progress: Callable[[int, int], None] | None = None) -> Ledger:
    """Compute the paper's numbers.

    Parameters
    ----------
    full : bool
        Also under the areas as Table II prints them.
    progress : callable, optional
        Called with the number of models done and their total.

    Returns
    -------
    Ledger
    """
    paper, robot = published(), load("hypertuna")
    models = MODELS | (AS_PRINTED if full else {})
    trials = {}
    for done, (name, choice) in enumerate(models.items(), 1):
        trials[name] = _try(robot.using(**choice), paper)
        if progress is not None:
            progress(done, len(models))
    findings = [finding for name, trial in trials.items() for finding in _model_findings(name, trial, paper)]
    findings += [*_paper_findings(trials, paper), *_to_come(trials)]
    order = list(paper["values"])
    entries = tuple(judge(paper, *finding) for finding in sorted(findings, key=lambda finding: order.index(finding[0])))
    made_by = provenance(robot)
    for key in ("joints", "areas"):  # each entry names its own
        del made_by[key]
    return Ledger(entries, _summary(entries), made_by, trials)


def ledger_record(ledger: Ledger) -> dict[str, Any]:
    """Say a ledger, for programs.

    Parameters
    ----------
    ledger : Ledger

    Returns
    -------
    dict
        What made it, its summary, the rules of the verdicts, the entries.
    """
    rules = [asdict(rule) for rule in RULES]
    entries = [asdict(entry) for entry in ledger.entries]
    return ledger.provenance | {"summary": ledger.summary, "rules": rules, "entries": entries}


def _try(robot: Robot, paper: Mapping[str, Any]) -> Trial:
    """Swim everything that the paper reports."""
    tank, turn = paper["tank"], named_gait(robot, "turning")
    phases = [(0.0, float(phase)) for phase in np.radians(tank["phase_deg"])]
    amplitudes = np.radians(list(tank["amplitude_deg"].values())).tolist()
    turns = [(0.0, float(phase)) for phase in np.radians(paper["turning"]["phase_deg"])]
    return Trial(
        robot=robot,
        gaits={name: swim(robot, named_gait(robot, name)) for name in robot.gaits},
        tank=sweep(robot, Gaits.grid(frequency=tank["frequency_hz"], amplitude=amplitudes, phase=phases)),
        turning=sweep(
            robot, Gaits.grid(frequency=[turn.frequency], amplitude=[turn.amplitude], phase=turns, bias=[turn.bias])
        ),
    )


def _model_findings(model: str, trial: Trial, paper: Mapping[str, Any]) -> Iterator[Finding]:
    """Yield what a model answers: speeds, changes by optimization, phases, turning."""
    gaits = trial.gaits
    for name in SPEEDS:
        yield f"speed/{name}", model, gaits[name].speed, _settled_note(gaits[name])
    gain = _change(gaits["unoptimised-max"].speed, gaits["optimised-max"].speed)
    yield "speed/change-max", model, gain, "optimised against unoptimised"
    for speed in ("0.3", "0.4", "0.5"):
        before, after = (gaits[f"{kind}optimised-{speed}"] for kind in ("un", ""))
        change = _change(before.cost_of_transport, after.cost_of_transport)
        note = f"mechanical: {before.cost_of_transport:.3g} to {after.cost_of_transport:.3g} J/(kg m)"
        yield f"cost-of-transport/change-{speed}", model, change, note
    yield _fastest_phase(model, trial, paper)
    yield from _turning(model, trial, paper)


def _paper_findings(trials: Mapping[str, Trial], paper: Mapping[str, Any]) -> Iterator[Finding]:
    """Yield what the paper's own model and numbers answer."""
    own = trials[PAPER]
    for row, level in enumerate(paper["tank"]["amplitude_deg"]):
        if f"optimal-phase/{level}" in paper["values"]:
            yield _optimal_phase(level, row, trials, paper)
    errors = [abs(own.gaits[name].speed / paper["values"][f"speed/{name}"]["value"] - 1) for name in SPEEDS]
    slow, fast = own.gaits["optimised-0.3"], own.gaits["optimised-max"]
    yield (
        "speed/model-error-max",
        PAPER,
        100 * max(errors),
        "over the eight gaits, as the paper's validation set is not published. With inertia and quadratic drag alone, "
        f"stride length does not depend on frequency: {slow.stride_length:.3f} and {fast.stride_length:.3f} for nearly "
        f"the same gait at {slow.gait.frequency:g} and {fast.gait.frequency:g} Hz, where the published speeds give "
        f"{_stride('optimised-0.3', own, paper):.3f} and {_stride('optimised-max', own, paper):.3f}",
    )
    yield _range(own.robot, paper)


def _to_come(trials: Mapping[str, Trial]) -> Iterator[Finding]:
    """Yield what later parts of hypertuna will compute."""
    best = trials[OURS].gaits["unoptimised-max"]
    share = best.cost_of_transport / published()["values"]["cost-of-transport/minimum"]["value"]
    cost = f"{best.cost_of_transport:.3g} J/(kg m)"
    note = f"the joints' mechanical power is {cost} of it, {100 * share:.0f} %, under {OURS}"
    yield "cost-of-transport/minimum", "to come: pumps, servos and energy", None, note
    for joint in ("I", "II"):
        yield f"bending/joint-{joint}", "to come: actuator", None, "from muscle pressure to the tail's bend"
    yield "control/settling", "to come: twin", None, "the robot's controller on the simulated robot"


def _change(before: float, after: float) -> float:
    """Change in percent."""
    return 100 * (after / before - 1)


def _settled_note(done: Swim) -> str:
    """Warn of a gait that is not settled."""
    return "" if done.settled else done.status_text


def _stride(name: str, trial: Trial, paper: Mapping[str, Any]) -> float:
    """Stride length of a published speed."""
    speed = paper["values"][f"speed/{name}"]["value"]
    return float(speed / (trial.gaits[name].gait.frequency * trial.robot.body.length))


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
    return f"optimal-phase/{level}", PAPER, best, note


def _fastest_phase(model: str, trial: Trial, paper: Mapping[str, Any]) -> Finding:
    """Phase of the fastest gait of the grid."""
    speed = trial.tank.speed.isel(bias=0).transpose("frequency", "amplitude", "phase").values
    frequency, amplitude, phase = np.unravel_index(speed.argmax(), speed.shape)
    level = list(paper["tank"]["amplitude_deg"])[amplitude]
    note = (
        f"fastest at {paper['tank']['frequency_hz'][frequency]:g} Hz and {level} amplitude, "
        f"{100 * _lead(speed[frequency, amplitude]):.1f} % ahead of the next phase"
    )
    return "optimal-phase/fastest", model, float(paper["tank"]["phase_deg"][phase]), note


def _turning(model: str, trial: Trial, paper: Mapping[str, Any]) -> Iterator[Finding]:
    """Yield the turning radius of the published gait, and the phase of the tightest turn."""
    length, done = trial.robot.body.length, trial.gaits["turning"]
    around = trial.turning.isel(frequency=0, amplitude=0, bias=0)
    radius, ahead = around.turn_radius.values / length, around.speed.values > 0
    phases = paper["turning"]["phase_deg"]
    way = "forward" if done.speed > 0 else "tail first"
    first = np.where(ahead, radius, np.inf).argmin()
    note = (
        f"mean distance of the nose from the center of the turn; swims {way} at {abs(done.speed):.2g} m/s. "
        f"The tightest turn that swims forward: {radius[first]:.3g} BL at {phases[first]:g} deg"
    )
    yield "turning/radius", model, done.turn_radius / length, note
    best = int(radius.argmin())
    note = f"swims {'forward' if ahead[best] else 'tail first'} there; radii of the grid are {np.min(radius):.2f} to "
    yield "turning/best-phase", model, float(phases[best]), f"{note}{np.max(radius):.2f} BL"


def _range(robot: Robot, paper: Mapping[str, Any]) -> Finding:
    """Range on the battery of Table I at the published cost of transport."""
    battery = robot.battery
    assert battery is not None  # the robot of the paper has one
    cost = paper["values"]["cost-of-transport/minimum"]["value"] * robot.body.mass  # J/m
    energy = battery.cells * battery.capacity * battery.voltage
    claimed = paper["values"]["range/claimed"]["value"] * 1e3 * cost
    charge, cell = paper["range"]["battery_ah"], paper["range"]["charged_cell_v"]
    lake = paper["lake"]["energy_wh"] * 3600 / paper["lake"]["distance_m"]
    lake_cost = float(cost_of_transport(lake, robot.body.mass, 1.0))
    note = (
        f"{battery.cells} cells x {battery.capacity / 3600:g} Ah x {battery.voltage:g} V = {energy / 3600:.1f} Wh, "
        f"over {cost / robot.body.mass:g} J/(kg m) x {robot.body.mass:g} kg. The claim needs {claimed / 3600:.0f} Wh: "
        f"{charge:g} Ah x {claimed / 3600 / charge:.1f} V, with all {battery.cells} cells in parallel "
        f"({battery.cells} x {charge / battery.cells:g} Ah) and in series ({battery.cells} x {cell:g} V) at once. "
        f"The lake run, {paper['lake']['energy_wh']:g} Wh for {paper['lake']['distance_m']:g} m or "
        f"{lake_cost:.1f} J/(kg m), gives {energy / lake / 1e3:.2g} km"
    )
    return "range/claimed", ARITHMETIC, energy / cost / 1e3, note


def _summary(entries: tuple[Entry, ...]) -> dict[str, Any]:
    """Add up: errors of the eight speeds by model, verdicts."""
    speeds: dict[str, list[Entry]] = {}
    for entry in entries:
        if entry.id.removeprefix("speed/") in SPEEDS:
            speeds.setdefault(entry.model, []).append(entry)
    errors = {model: np.array([entry.relative_error for entry in part], float) for model, part in speeds.items()}
    verdicts = [entry.verdict for entry in entries]
    return {
        "speeds": {
            model: {
                "rms_relative_error": float(np.sqrt(np.mean(error**2))),
                "largest_relative_error": float(np.abs(error).max()),
                "largest_at": speeds[model][int(np.abs(error).argmax())].id,
            }
            for model, error in errors.items()
        },
        "verdicts": {verdict: verdicts.count(verdict) for verdict in VERDICTS},
    }
