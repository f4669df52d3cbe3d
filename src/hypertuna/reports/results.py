"""One page on results of any kind: swims, runs of the twin, posture tests, fits, optima and Pareto fronts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypeAlias

import numpy as np

from hypertuna.errors import InputError
from hypertuna.identification.identify import Fit
from hypertuna.optimization.optimum import Optimum
from hypertuna.optimization.pareto import Front
from hypertuna.reports.html import WIDTH, Part, Picture, Section, Table, write_page
from hypertuna.simulation.posture_test import Held, PostureTest
from hypertuna.simulation.run import TwinRun
from hypertuna.swimming.beat import QUANTITIES
from hypertuna.swimming.gait import Gait
from hypertuna.swimming.swim import Swim

MOST = 8  # gaits of a front in a table
Result: TypeAlias = Swim | TwinRun | PostureTest | Fit | Optimum | Front


def report(results: Result | Sequence[Result], path: str | Path, *, title: str = "") -> Path:
    """Write results as one self-contained HTML page, for wide screens and phones, light and dark.

    Parameters
    ----------
    results : Swim, TwinRun, PostureTest, Fit, Optimum, Front, or sequence of them
        A section or several for each, in their order.
    path : str or Path
        Of the page; replaced if it exists.
    title : str
        Of the page; the names of the robots if left out.

    Returns
    -------
    Path

    Raises
    ------
    InputError
        If there is no result, one is of another kind, or the file cannot be written.
    """
    every = [results] if isinstance(results, Result) else list(results)
    if not every:
        raise InputError("must hold at least one result", key="results", value="empty", fix="give a swim, or a fit")
    sections = [_renamed(section, k) for k, result in enumerate(every) for section in _sections(result)]
    robots = dict.fromkeys(result.robot.description for result in every)
    title = title or " and ".join(dict.fromkeys(result.robot.name for result in every))
    return write_page(title, sections, path, lede="\n\n".join(f"{text}." for text in robots))


def posture_table(test: PostureTest) -> Table:
    """Tabulate settling times of peak bends, and the largest amplitude that was held."""
    reach = {(one.joint, one.frequency): one for one in test.reach}
    eased = {(one.joint, one.frequency): one for one in test.eased}
    rows: list[list[str | float]] = []
    for one in test.held:
        key = (one.joint, one.frequency)
        row = [f"{one.frequency:g} Hz", one.name, f"{np.degrees(one.angle):.4g}", _settles(one)]
        if test.reach:
            row += [f"{np.degrees(reach[key].amplitude):.1f}", spelled_limits(reach[key].limits)]
        if test.eased:
            within = eased.get(key)
            row.append("" if within is None else f"{_settles(within)} at {np.degrees(within.angle):.1f} deg")
        rows.append([*row])
    columns = ["frequency", "joint", "set [deg]", "settles [s]"]
    columns += ["holds up to [deg]", "then stopped by"] if test.reach else []
    columns += ["settles [s] within reach"] if test.eased else []
    shows = "When all peak bends are within half a degree of the set angle and stay there"
    shows += ", the largest amplitude that is held, and what stops more." if test.reach else "."
    made = f"In {test.medium}, from rest."
    made += " The largest amplitude to half a degree." if test.reach else ""
    return Table(columns, rows, shows, made)


def spelled_limits(names: Sequence[str]) -> str:
    """Return the names of limits as words; a dash for none."""
    return ", ".join(name.replace("_", " ") for name in names) or "–"


def _settles(one: Held) -> str:
    """Return a settling time [s], or the end of the run that was too short."""
    return f"> {one.time[-1]:.1f}" if one.settling is None else f"{one.settling:.2f}"


def _sections(result: Result) -> list[Section]:
    """Return the sections of one result."""
    match result:
        case Swim():
            return [_swim(result)]
        case TwinRun():
            return [_twin(result)]
        case PostureTest():
            return [_posture(result)]
        case Fit():
            from hypertuna.reports.fit import fit_sections

            return fit_sections(result)
        case Optimum():
            return [_optimum(result)]
        case Front():
            return [_front(result)]
    rule = "must be a Swim, TwinRun, PostureTest, Fit, Optimum or Front"
    raise InputError(rule, key="results", value=type(result).__name__, fix="leave it out")


def _renamed(section: Section, k: int) -> Section:
    """Give the pictures of result k unique names."""
    parts = [replace(p, name=f"result-{k}-{p.name}") if isinstance(p, Picture) else p for p in section.parts]
    return Section(section.title, parts)


def _swim(swim: Swim) -> Section:
    """Show how a gait swims."""
    from hypertuna.swimming.animation import slowed, swimming_svg

    parts: list[Part] = [_numbers(swim)]
    if swim.status != "diverged":
        fish = swimming_svg(swim)
        shows = f"The body through {'the' if swim.duration is None else 'its last'} beat, {slowed(swim)}."
        parts.append(Picture("body", fish, shows, "The motion is computed; the body's thickness is schematic."))
        parts.append(_motion(swim))
    return Section(f"A swim at {swim.gait.frequency:.4g} Hz", parts)


def _twin(run: TwinRun) -> Section:
    """Show a run of the twin."""
    from hypertuna.simulation.plots import plot_twin

    rows: list[list[str | float]] = [*_gait_rows(run.gait)]
    if run.medium == "water":
        rows += [["speed", run.speed, "m/s"], ["speed", run.speed_bl, "body lengths/s"]]
    for name, swing in zip(run.joints, np.degrees(run.swing), strict=True):
        rows.append([f"amplitude reached, joint {name}", float(swing), "deg"])
    rows.append(["electrical power", run.power, "W"])
    if run.medium == "water":
        rows.append(["cost of transport", run.cost_of_transport, "J/(kg m)"])
    rows.append(["largest pressure in a pump", float(run.pressure_max.max()) / 1e3, "kPa"])
    summary = f"Command and response of {run.robot.name}, over the last whole beats."
    table = Table(["quantity", "value", "unit"], rows, summary, f"{run.duration:g} s in {run.medium} from {run.start}.")
    shows = "Bend of the joints beside its setpoint, pressures in the pumps, electrical power"
    shows += ", speed and path." if run.medium == "water" else "."
    loop = "Closed loop" if run.closed_loop else "Open loop"
    picture = Picture("twin", plot_twin(run, width=WIDTH), shows, f"{loop}, seed {run.seed}.")
    title = f"The twin at {run.gait.frequency:.4g} Hz"
    return Section(title, ["\n\n".join(run.sentences), table, picture])


def _posture(test: PostureTest) -> Section:
    """Show how the posture control settles."""
    from hypertuna.simulation.plots import plot_posture

    shows = "Bend from rest to the set angle, error of the peak bends beat by beat, and the largest amplitude held."
    picture = Picture("posture", plot_posture(test, width=WIDTH), shows, f"In {test.medium}, {test.duration:g} s each.")
    return Section("Posture control", [picture, posture_table(test)])


def _motion(swim: Swim) -> Picture:
    """Return the figure of a swim."""
    from hypertuna.swimming.plots import plot_swim

    how = "The settled beat." if swim.duration is None else f"From rest, {swim.duration:g} s."
    shows = "Paths of nose and tail tip, midlines, forward speed and mechanical power."
    return Picture("swim", plot_swim(swim, width=WIDTH), shows, f"{how} {swim.status_text}")


def _numbers(swim: Swim) -> Table:
    """Tabulate gait and swim."""
    rows: list[list[str | float]] = [
        *_gait_rows(swim.gait),
        ["speed", swim.speed, "m/s"],
        ["speed", swim.speed_bl, "body lengths/s"],
        ["mechanical power", swim.power, "W"],
        ["cost of transport", swim.cost_of_transport, "J/(kg m)"],
        ["Strouhal number", swim.strouhal, "1"],
        ["efficiency", swim.efficiency, "1"],
    ]
    if np.isfinite(swim.turn_radius):
        rows.append(["turning radius", swim.turn_radius, "m"])
    model = swim.robot.model
    return Table(
        ["quantity", "value", "unit"],
        rows,
        f"The gait, and how {swim.robot.name} swims it.",
        f"{model.joints.capitalize()} joints, {model.water} water law. {swim.status_text}",
    )


def _gait_rows(gait: Gait) -> list[list[str | float]]:
    """Return rows with a gait."""
    rows: list[list[str | float]] = [["frequency", gait.frequency, "Hz"]]
    for name in ("amplitude", "phase", "bias"):
        angles = np.degrees(getattr(gait, name))
        if name != "bias" or angles.any():
            rows.append([name, ", ".join(f"{angle:.4g}" for angle in angles), "deg"])
    return rows


def _optimum(best: Optimum) -> Section:
    """Show an optimum."""
    ends = ", ".join(f"`{name}` at its {side} bound" for name, side in best.bounds.items())
    text = [
        f"{best.stop} {best.evaluations} gaits were swum, seed {best.seed}.",
        best.remark,
        f"{ends}." if ends else "",
    ]
    parts: list[Part] = ["\n\n".join(filter(None, text))]
    if best.swim is not None:
        parts += [_numbers(best.swim), _motion(best.swim)]
    name = best.objective.name if best.objective.expected is None else f"{best.objective.expected:g} m/s"
    return Section(f"The best gait for {name.replace('_', ' ')}, by {best.method}", parts)


def _front(front: Front) -> Section:
    """Show a Pareto front."""
    from hypertuna.optimization.plots import plot_pareto

    names = " and ".join(name.replace("_", " ") for name in front.objectives)
    shows = f"{len(front.x)} gaits of which none is better than another in every objective."
    made = f"NSGA-II{', then polished by exact derivatives' if front.polished else ''}; {front.evaluations} gaits swum."
    picture = Picture("front", plot_pareto(front, width=WIDTH), shows, made)
    return Section(f"Pareto front of {names}", [front.stop, _gaits(front), picture])


def _gaits(front: Front) -> Table:
    """Tabulate gaits from one end of a front to the other."""
    shown = np.unique(np.linspace(0, len(front.gaits) - 1, min(len(front.gaits), MOST)).astype(int))
    columns = [f"{name.replace('_', ' ')} [{QUANTITIES[name].unit}]" for name in front.objectives]
    rows: list[list[str | float]] = []
    for k in shown:
        phases = ", ".join(f"{phase:.3g}" for phase in np.degrees(front.gaits[k].phase))
        rows.append([*front.values[k].tolist(), front.gaits[k].frequency, phases])
    shows = "Gaits from one end of the front to the other: objectives, frequency and phases."
    return Table([*columns, "f [Hz]", "phase [deg]"], rows, shows)
