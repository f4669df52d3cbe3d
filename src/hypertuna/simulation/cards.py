"""Cards that terminals and notebooks show for runs of the twin, losses, posture tests and dives."""

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from hypertuna.arrays import Array
from hypertuna.description.pose import body_points, coordinate_shares
from hypertuna.display import Card, Facts, Part, Table, cards, number, tables
from hypertuna.frames import rotation_of
from hypertuna.io.quantity import ZERO_CELSIUS, listed, quantity
from hypertuna.pictures import bars_svg, captioned, curve_svg, track_svg
from hypertuna.simulation.dive import Dive
from hypertuna.simulation.losses import PLACES, Losses
from hypertuna.simulation.posture import MAX_ERROR, Held, PostureTest
from hypertuna.simulation.recorded import CONDITIONS
from hypertuna.simulation.run import TwinRun
from hypertuna.simulation.sea_run import SeaRun
from hypertuna.swimming.gait import gait_text
from hypertuna.swimming.outline import bodies, film_svg, followed, water_step

BEATS, FRAMES = 3, 20  # beats that the animation shows, and frames per beat
MIN_ROWS = 8  # rows of the record per beat that are needed to draw the body
CAVITATED = "the oil cavitated in a cylinder"  # meaning of the limit "cavitation"
SWINGS = ("bend_amplitude", "bend_lag", "bend_peak")  # of a hinge, as in a settled beat
MIN_SPEED = 0.01  # body lengths per second: a slower robot stands still, and has no cost of transport
BACKWARD = "The robot does not swim head first, or hardly moves: there is no cost of transport and no range."


def swims_forward(run: TwinRun) -> bool:
    """Return whether the robot swims head first; also true for runs without a speed: in air, or diverged."""
    return math.isnan(run.speed) or run.speed_bl > MIN_SPEED


def joint_rows(run: TwinRun) -> list[dict[str, Any]]:
    """Return a row for each joint group, with setpoints and the motion over the last whole beats."""
    return _rows(
        run.joints,
        amplitude_set_deg=np.degrees(run.gait.amplitude),
        swing_deg=np.degrees(run.swing),
        first_harmonic_deg=np.degrees(run.first_harmonic),
        swing_error_deg=np.degrees(run.swing - run.gait.amplitude),
        bias_set_deg=np.degrees(run.gait.bias),
        bias_deg=np.degrees(run.bias),
        phase_set_deg=np.degrees(run.gait.phase),
        phase_deg=np.degrees(run.phase),
    )


def hinge_rows(run: TwinRun) -> list[dict[str, Any]]:
    """Return a row for each hinge: amplitude, lag and largest angle of its swing, and the part of time in its stops."""
    angles = {name: [math.degrees(bend[name]) for bend in run.bends] for name in SWINGS}
    in_stops = [bend["in_stops"] for bend in run.bends]
    return _rows(run.hinges, **{f"{name}_deg": column for name, column in angles.items()}, in_stops=in_stops)


def circuit_rows(run: TwinRun) -> list[dict[str, Any]]:
    """Return a row for each oil circuit with its largest, smallest and highest pressure [kPa]."""
    pressures = {"max": run.pressure_max, "min": run.pressure_min, "highest": run.pressure_highest}
    return _rows(run.circuits, **{f"pressure_{name}_kpa": values / 1e3 for name, values in pressures.items()})


def _rows(names: Sequence[str], **columns: Any) -> list[dict[str, Any]]:
    """Return a row for each name, with its value of each column."""
    return [{"name": name} | {key: values[k] for key, values in columns.items()} for k, name in enumerate(names)]


def twin_sentences(run: TwinRun) -> list[str]:
    """Return the run's sentences, and a warning if the robot did not swim forward."""
    return [*run.sentences, *([] if swims_forward(run) else [BACKWARD])]


@cards.of(TwinRun)
def twin_card(run: TwinRun) -> Card:
    """Show a run: totals, joints, circuits, losses, sentences."""
    loop = "closed loop" if run.closed_loop else "open loop"
    oil = f", oil at {run.temperature - ZERO_CELSIUS:.3g} C" if run.circuits else ""
    summary = run.summary()
    if not swims_forward(run):
        summary["cost_of_transport_j_per_kg_m"] = quantity("cost_of_transport", "–")
    parts: list[Part] = [(f"{run.duration:g} s in {run.medium} from {run.start}, {loop}{oil}", "dim")]
    parts += [Facts(summary, digits=3), "", _joint_table(run)]
    if run.hinges:
        parts += ["", _hinge_table(run)]
    servos = [group.name for group in run.robot.joints if not group.drive.oil]
    if servos and run.closed_loop:
        lag = "the swing error and the lag of the phase are the servo's own"
        uncorrected = f"No sensor reads the bend of {listed(servos)}, so the controller does not correct it"
        parts.append((f"{uncorrected}: {lag}.", "dim"))
    parts += ["", *(_pressures(run) if run.circuits else ()), *_losses(run), ""]
    good = run.settled and not run.limits and not run.faults
    bad = run.status == "diverged" or bool(run.faults)
    for k, sentence in enumerate(twin_sentences(run)):
        parts.append((sentence, "green" if good or (k == 0 and run.settled) else "bold red" if bad else "yellow"))
    swims = run.medium == "water"
    name, label = ("speed", "speed [m/s] over time [s]") if swims else ("power", "electrical power [W] over time [s]")
    picture = None if run.status == "diverged" else lambda: last_beats(run) + curve_svg(run.time, run.data[name], label)
    return Card(f"{run.robot.name}, {gait_text(run.gait)}", parts, picture)


def _pressures(run: TwinRun) -> Iterator[Part]:
    """Yield the card's table of pressures in the oil circuits."""
    yield f"cylinder pressure, peaks within ticks, {_beats(run)}", "dim"
    names = ("min", "max", "highest")
    rows = [(row["name"], *(f"{row[f'pressure_{name}_kpa']:.0f}" for name in names)) for row in circuit_rows(run)]
    yield Table(["\ncircuit", "min\n[kPa]", "max\n[kPa]", "whole run\n[kPa]"], rows)
    yield ""


def _losses(run: TwinRun) -> Iterator[Part]:
    """Yield the card's table of losses: the power lost at each place."""
    losses = run.losses
    yield f"where the {number(losses.power, 'W')} of the cells go, {_beats(run)}", "dim"
    rows = [
        (place, f"{losses.at(place):.3g}", f"{100 * losses.at(place) / losses.power:.0f}", losses.named(place))
        for place in PLACES
        if losses.at(place)
    ]
    yield Table(["\nplace", "mean\n[W]", "part\n[%]", "\nof it [W]"], rows, left=(0, 3), fold=3)


def _beats(run: TwinRun) -> str:
    """Return a phrase that names the beats over which means are taken, such as "last 3 beats"."""
    return f"last {run.beat_count} beats" if run.beat_count > 1 else "last beat"


def _joint_table(run: TwinRun) -> Table:
    """Return the table of setpoints and motions of the joints [deg]."""
    columns = [("swing", "swing_deg", ".1f"), ("amplitude set", "amplitude_set_deg", ".1f")]
    columns += [("swing error", "swing_error_deg", "+z.1f")]
    columns += [("bias", "bias_deg", "z.1f"), ("set", "bias_set_deg", ".1f")] if any(run.gait.bias) else []
    columns += [("phase", "phase_deg", "z.0f"), ("set", "phase_set_deg", ".0f")]
    rows = [(row["name"], *(f"{row[key]:{form}}" for _, key, form in columns)) for row in joint_rows(run)]
    return Table(["\njoint", *(f"{head}\n[deg]" for head, *_ in columns)], rows)


def _hinge_table(run: TwinRun) -> Table:
    """Return the table of the hinges' swings [deg], with the part of time that they spend in their stops."""
    rows = [
        (row["name"], *(f"{row[f'{name}_deg']:.1f}" for name in SWINGS), stops)
        for row, hinge in zip(hinge_rows(run), run.robot.hinges, strict=True)
        for stops in ["none" if hinge.stop is None else f"{100 * row['in_stops']:.0f} %"]
    ]
    return Table(["\nhinge of", "amplitude\n[deg]", "lag\n[deg]", "largest\n[deg]", "in its\nstops"], rows)


@cards.of(SeaRun)
def sea_card(run: SeaRun) -> Card:
    """Show a run at sea: distance, depth, speed, power, heading and track."""
    title = f"Twin of {run.robot.name} at sea: {gait_text(run.gait)}"
    if run.status == "diverged":
        return Card(title, [run.divergence])
    distance = float(np.hypot(*(run.position[-1, :2] - run.position[0, :2])))
    facts = {
        "duration": number(run.duration, "s"),
        "from the start": number(distance, "m"),
        "depth at the end": number(float(run.depth[-1]), "m"),
        "mean speed ahead": number(float(run.speed.mean()), "m/s"),
        "mean electrical power": number(float(run.data["power"].mean()), "W"),
        "heading at the end": number(float(np.degrees(run.heading[-1])), "deg"),
    }
    return Card(title, [Facts(facts)], lambda: last_beats(run) + _track_svg(run) + _height_svg(run))


@cards.of(Losses)
def losses_card(losses: Losses) -> Card:
    """Show where the power of a run goes, by place and loss."""
    facts = {"power of the cells": number(losses.power, "W")}
    facts |= {place: number(losses.at(place), "W") for place in PLACES}
    rows = [
        (loss.text, number(loss.power, "W"), number(100 * loss.power / losses.power, "%")) for loss in losses.losses
    ]
    bars = [(loss.name, 0.0, 100 * loss.power / losses.power) for loss in losses.losses]
    parts: list[Part] = [Facts(facts), Table(("loss", "power", "part"), rows)]
    return Card(f"Losses of {losses.title}", parts, lambda: bars_svg(bars, "part of the power [%]"))


def _height_svg(run: SeaRun) -> str:
    """Draw the height of the nose over time as SVG."""
    return curve_svg(run.time, -run.depth, "height [m] over time [s]")


def _track_svg(run: SeaRun) -> str:
    """Draw the track of the nose from above as SVG, as a moving average over a beat."""
    east, north = (run.averaged(run.position[:, axis]) for axis in (0, 1))
    return track_svg(east, north, run.duration, "mean of the beat: north [m] over east [m]")


def posture_rows(test: PostureTest) -> list[dict[str, Any]]:
    """Return a row for each joint group and frequency: the settled result, and arrays with a value per beat."""
    rows = []
    for held, reach, easier in test.cases:
        row: dict[str, Any] = {
            "frequency_hz": held.frequency,
            "joint": held.name,
            "angle_set_deg": np.degrees(held.angle_set),
            "settling_s": held.settling,
            "settling_measured_s": held.settling_measured,
            "error_deg": np.degrees(held.error[-1]),
            "error_measured_deg": np.degrees(held.error_measured[-1]),
            "limits": list(held.limits),
        }
        if reach is not None:
            row |= {"amplitude_max_deg": np.degrees(reach.amplitude_max), "stopped_by": list(reach.limits)}
        if easier is not None:
            row |= {"reachable_angle_deg": np.degrees(easier.angle_set), "reachable_settling_s": easier.settling}
        left, right = np.degrees(held.peaks).T
        row |= {"beat_end_s": held.time, "peak_left_deg": left, "peak_right_deg": right}
        row["beat_error_deg"] = np.degrees(held.error)
        row["beat_error_measured_deg"] = np.degrees(held.error_measured)
        rows.append(row)
    return rows


@tables.of(PostureTest)
def posture_columns(test: PostureTest) -> dict[str, list[Any]]:
    """Return the results of each joint group at each frequency as columns, without the arrays per beat."""
    rows = posture_rows(test)
    names = [name for name, value in rows[0].items() if not isinstance(value, list | np.ndarray)]
    return {name: [np.nan if row[name] is None else row[name] for row in rows] for name in names}


def spelled_limits(names: Sequence[str]) -> str:
    """Return the names of limits as words; a dash for none."""
    return ", ".join(name.replace("_", " ") for name in names) or "–"


def limit_sentences(result: PostureTest) -> list[str]:
    """Return a sentence that explains each limit that acted."""
    meanings = {name: text for name, (_, text) in CONDITIONS.items()} | {"cavitation": CAVITATED}
    limits = [one.limits for one in result.held] + [one.limits for one in result.reach]
    acted = dict.fromkeys(name for names in limits for name in names)
    return [f"{name.replace('_', ' ').capitalize()}: {meanings[name]}." for name in acted]


def posture_table(test: PostureTest) -> Table:
    """Return the table of a test, with a row for each frequency and joint."""
    header = ["f\n[Hz]", "\njoint", "set\n[deg]", "settles\n[s]", "error\n[deg]", "\nlimited by"]
    header += ["holds up to\n[deg]", "\nthen limited by"] if test.reach else []
    header += ["within reach\nsettles"] if test.eased else []
    rows = []
    for held, reach, easier in test.cases:
        cells = [f"{held.frequency:g}", held.name, f"{np.degrees(held.angle_set):.4g}", _settles(held)]
        cells += [f"{np.degrees(held.error[-1]):.2f}", spelled_limits(held.limits)]
        cells += [f"{np.degrees(reach.amplitude_max):.1f}", spelled_limits(reach.limits)] if reach else []
        within = f"{_settles(easier)} s at {np.degrees(easier.angle_set):.1f} deg" if easier else ""
        rows.append([*cells, *([within] if test.eased else [])])
    return Table(header, rows, left=(1, 5, 7, 8))


def _settles(held: Held) -> str:
    """Write a settling time [s], or "> duration" if the joint did not settle within the run."""
    return f"> {held.time[-1]:.1f}" if held.settling is None else f"{held.settling:.2f}"


@cards.of(PostureTest)
def posture_card(test: PostureTest) -> Card:
    """Show a posture test: its table, the limits that acted, and whether all joints settled."""
    parts: list[Part] = [posture_table(test), *((text, "dim") for text in limit_sentences(test))]
    unsettled = ", ".join(f"{held.name} at {held.frequency:g} Hz" for held in test.held if held.settling is None)
    within = f"within {math.degrees(MAX_ERROR):g} deg"
    slowest = max((held.settling for held in test.held if held.settling is not None), default=0.0)
    if unsettled:
        parts.append((f"Not {within} at the end: {unsettled}.", "bold red"))
    else:
        parts.append((f"Every peak bend is {within} after {slowest:.2f} s, and stays.", "green"))
    title = f"{test.robot.name}, posture control in {test.medium}, {test.duration:g} s from rest"
    return Card(title, parts, lambda: last_beats(test.held[0].run))


@cards.of(Dive)
def dive_card(dive: Dive) -> Card:
    """Show a dive: a row for each half, and its sentences."""
    run = dive.run
    rows = []
    for leg in dive.legs:
        fins, pitch = f"{math.degrees(leg.fins):+z.3g}", f"{math.degrees(leg.pitch):+z.1f}"
        path, rate = f"{leg.depth[0]:.2f} to {leg.depth[1]:.2f}", f"{100 * leg.depth_rate:+z.1f}"
        rows.append((fins, path, rate, pitch, f"{leg.speed:.3f}"))
    heads = ["fins\n[deg]", "depth\n[m]", "depth rate\n[cm/s]", "pitch\n[deg]", "speed\n[m/s]"]
    good = run.status == "completed" and all(leg.right for leg in dive.legs)
    style = "bold red" if not good else "green" if all(leg.steady for leg in dive.legs) else "yellow"
    parts: list[Part] = [(f"{run.duration:g} s from a depth of {run.depth[0]:g} m", "dim"), Table(heads, rows, left=())]
    parts += ["", *((sentence, style) for sentence in dive.sentences)]
    picture = None if run.status == "diverged" else lambda: last_beats(run) + _height_svg(run)
    return Card(f"{run.robot.name}, {gait_text(run.gait)}", parts, picture)


def last_beats(run: TwinRun | SeaRun) -> str:
    """Return an animated SVG of the body over a run's last beats, with a caption that names the time."""
    time, frequency = run.time, run.gait.frequency
    if len(time) < 2 or (time[1] - time[0]) * frequency * MIN_ROWS > 1:
        return captioned("", f"The body is not drawn: the record has fewer than {MIN_ROWS} rows a beat.")
    begin = max(time[0], time[-1] - BEATS / frequency)
    seconds = time[-1] - begin
    instants = np.linspace(begin, time[-1], round(FRAMES * seconds * frequency) + 1)
    hinges = [run.data["hinge_angle"]] if run.robot.hinges else []
    columns = np.column_stack([_pose(run), run.data["angle"], *hinges])
    rows = np.stack([np.interp(instants, time, column) for column in columns.T], axis=1)
    pose, bends = rows[:, :3], rows[:, 3:]
    midlines = body_points(run.robot, pose, bends @ coordinate_shares(run.robot).T)
    shapes = bodies(run.robot, followed(midlines, pose[:, 2]))
    step = water_step(run.robot, midlines[:, 0], pose[:, 2]) / (seconds * frequency)
    film = film_svg(shapes, step, 1 / frequency, seconds, f"{run.robot.name} from above")
    span = f"{number(begin)} to {number(time[-1], 's')}"
    return captioned(film, f"The last {seconds * frequency:.2g} beats from above, {span}, in real time.")


def _pose(run: TwinRun | SeaRun) -> Array:
    """Return pose of the head from above (T, 3): x, y [m] of the nose, angle of the axis from nose to tail [rad]."""
    if isinstance(run, TwinRun):
        return np.column_stack([run.data[name] for name in ("x", "y", "heading")])
    axis = rotation_of(run.attitude)[:, :, 0]
    return np.column_stack([run.position[:, :2], np.unwrap(np.arctan2(axis[:, 1], axis[:, 0]))])
