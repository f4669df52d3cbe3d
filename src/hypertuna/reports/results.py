"""One page on results of any kind: swims, runs of the twin, posture tests, fits, optima and Pareto fronts."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from hypertuna.arguments import checked
from hypertuna.errors import InputError
from hypertuna.identification.identify import Fit
from hypertuna.optimization.optimum import Optimum
from hypertuna.optimization.pareto import Front
from hypertuna.reports.html import WIDTH, Picture, Section, Shown, Table, compose, write_page
from hypertuna.reports.studio import studio_command
from hypertuna.simulation.posture import Held, PostureTest
from hypertuna.simulation.run import TwinRun
from hypertuna.swimming.beat import QUANTITIES
from hypertuna.swimming.gait import Gait
from hypertuna.swimming.swim import Swim

MAX_GAITS = 8  # of a front in a table
QUANTITY = ("quantity", "value", "unit")
Result: TypeAlias = Swim | TwinRun | PostureTest | Fit | Optimum | Front


@checked
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
    rows = []
    for one in test.held:
        key = (one.joint, one.frequency)
        row = [f"{one.frequency:g} Hz", one.name, f"{np.degrees(one.angle_set):.4g}", _settles(one)]
        if test.reach:
            row += [f"{np.degrees(reach[key].amplitude_max):.1f}", spelled_limits(reach[key].limits)]
        if test.eased:
            within = eased.get(key)
            row.append("" if within is None else f"{_settles(within)} at {np.degrees(within.angle_set):.1f} deg")
        rows.append(row)
    columns = ["frequency", "joint", "set [deg]", "settles [s]"]
    columns += ["holds up to [deg]", "then stopped by"] if test.reach else []
    columns += ["settles [s] within reach"] if test.eased else []
    shows = "When all peak bends are within half a degree of the set angle and stay there"
    shows += ", the largest amplitude that is held, and what stops more." if test.reach else "."
    made = f"In {test.medium}, from rest.{' The largest amplitude to half a degree.' if test.reach else ''}"
    return Table(columns, rows, shows, made)


def spelled_limits(names: Sequence[str]) -> str:
    """Return the names of limits as words; a dash for none."""
    return ", ".join(name.replace("_", " ") for name in names) or "–"


def _settles(one: Held) -> str:
    """Return a settling time [s], or the end of the run that was too short."""
    return f"> {one.time[-1]:.1f}" if one.settling is None else f"{one.settling:.2f}"


def _sections(result: Result) -> list[Section]:
    """Return the sections of one result."""
    from hypertuna.optimization.plots import plot_pareto
    from hypertuna.reports.fit import fit_sections
    from hypertuna.simulation.plots import plot_posture, plot_twin
    from hypertuna.swimming.outline import slowed

    shown: dict[str, Shown] = {}
    facts: dict[str, Any] = {}
    match result:
        case Fit():
            return fit_sections(result)
        case Swim():
            command = studio_command(result.robot, result.gait)
            shown, facts = _swim(result), {"slowed": slowed(result), "studio_command": command}
        case TwinRun():
            facts = {"studio_command": studio_command(result.robot, result.gait)}
            shown = {"numbers": _twin_table(result), "twin": plot_twin(result, width=WIDTH)}
        case PostureTest():
            shown = {"posture": plot_posture(result, width=WIDTH), "settling": posture_table(result)}
        case Optimum():
            shown = {} if result.swim is None else _swim(result.swim)
            expected = result.objective.expected
            name = result.objective.name.replace("_", " ") if expected is None else f"{expected:g} m/s"
            facts = {"objective": name}
            if result.swim is not None:
                facts["studio_command"] = studio_command(result.robot, result.swim.gait)
        case Front():
            shown = {"gaits": _front_table(result), "front": plot_pareto(result, width=WIDTH)}
            facts = {"objective": " and ".join(name.replace("_", " ") for name in result.objectives)}
        case _:
            rule = "must be a Swim, TwinRun, PostureTest, Fit, Optimum or Front"
            raise InputError(rule, key="results", value=type(result).__name__, fix="leave it out")
    return compose("hypertuna.reports", "results", shown, kind=type(result).__name__, result=result, **facts)


def _renamed(section: Section, k: int) -> Section:
    """Give the pictures of result k unique names."""
    parts = [replace(p, name=f"result-{k}-{p.name}") if isinstance(p, Picture) else p for p in section.parts]
    return Section(section.title, parts)


def _swim(swim: Swim) -> dict[str, Shown]:
    """Return the numbers of a swim and, unless it diverged, its figures."""
    from hypertuna.swimming.outline import swimming_svg
    from hypertuna.swimming.plots import plot_swim

    rows = [
        *_gait_rows(swim.gait),
        ("speed", swim.speed, "m/s"),
        ("speed", swim.speed_bl, "body lengths/s"),
        *([] if swim.band is None else [("speed by the estimates", swim.band.ends(), "m/s")]),
        ("mechanical power", swim.mechanical_power, "W"),
        ("cost of transport", swim.cost_of_transport, "J/(kg m)"),
        ("Strouhal number", swim.strouhal, "1"),
        ("efficiency", swim.efficiency, "1"),
    ]
    if np.isfinite(swim.turn_radius):
        rows.append(("turn radius", swim.turn_radius, "m"))
    numbers: dict[str, Shown] = {"numbers": Table(QUANTITY, rows)}
    if swim.status == "diverged":
        return numbers
    return numbers | {"body": swimming_svg(swim), "swim": plot_swim(swim, width=WIDTH)}


def _gait_rows(gait: Gait) -> list[tuple[str, str | float, str]]:
    """Return rows with a gait."""
    rows: list[tuple[str, str | float, str]] = [("frequency", gait.frequency, "Hz")]
    for name in ("amplitude", "phase", "bias"):
        angles = np.degrees(getattr(gait, name))
        if name != "bias" or angles.any():
            rows.append((name, ", ".join(f"{angle:.4g}" for angle in angles), "deg"))
    return rows


def _twin_table(run: TwinRun) -> Table:
    """Tabulate command and response of the twin."""
    swims, rows = run.medium == "water", _gait_rows(run.gait)
    if swims:
        rows += [("speed", run.speed, "m/s"), ("speed", run.speed_bl, "body lengths/s")]
    for name, swing in zip(run.joints, np.degrees(run.swing), strict=True):
        rows.append((f"amplitude reached, joint {name}", float(swing), "deg"))
    rows.append(("electrical power", run.electrical_power, "W"))
    if swims:
        rows.append(("cost of transport", run.cost_of_transport, "J/(kg m)"))
    rows.append(("largest pressure in a pump", float(run.pressure_max.max()) / 1e3, "kPa"))
    return Table(QUANTITY, rows)


def _front_table(front: Front) -> Table:
    """Tabulate gaits from one end of a front to the other."""
    shown = np.unique(np.linspace(0, len(front.gaits) - 1, min(len(front.gaits), MAX_GAITS)).astype(int))
    columns = [f"{name.replace('_', ' ')} [{QUANTITIES[name].unit}]" for name in front.objectives]
    rows = []
    for k in shown:
        phases = ", ".join(f"{phase:.3g}" for phase in np.degrees(front.gaits[k].phase))
        rows.append([*front.values[k].tolist(), front.gaits[k].frequency, phases])
    return Table([*columns, "f [Hz]", "phase [deg]"], rows)
