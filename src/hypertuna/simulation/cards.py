"""What notebooks and shells show of runs of the twin and of dives."""

from typing import Any

import numpy as np

from hypertuna.arrays import Array
from hypertuna.display import Card, number
from hypertuna.frames import rotation_of
from hypertuna.pictures import bars_svg, captioned, curve_svg, track_svg
from hypertuna.simulation.dive import Dive
from hypertuna.simulation.losses import PLACES, Losses
from hypertuna.simulation.posture import PostureTest
from hypertuna.simulation.run import TwinRun
from hypertuna.simulation.sea_run import SeaRun
from hypertuna.swimming.cards import gait_text
from hypertuna.swimming.outline import bodies, film_svg, followed, water_step
from hypertuna.swimming.trajectory import body_points, group_shares

BEATS, FRAMES = 3, 20  # shown, and pictures of each
COARSE = 8  # rows of the record in a beat, below which the body cannot be drawn


def twin_card(run: TwinRun) -> Card:
    """Show speed, power and pressures of the last beats, and the swings of the joints."""
    if run.status == "diverged":
        return Card(f"Twin of {run.robot.name}: {gait_text(run.gait)}", (), run.divergence)
    swims = run.medium == "water"
    facts = [("speed", f"{number(run.speed, 'm/s')} ({number(run.speed_bl, 'BL/s', 2)})")] if swims else []
    facts += [("electrical power", number(run.electrical_power, "W"))]
    facts += [("cost of transport", number(run.cost_of_transport, "J/(kg m)"))] if swims else []
    facts += [("largest pressure", number(float(run.pressure_max.max()) / 1e3, "kPa"))] if run.circuits else []
    facts += [("change per beat", number(100 * run.change_per_beat, "%", 2)), ("duration", number(run.duration, "s"))]
    swings = zip(run.joints, np.degrees(run.gait.amplitude), np.degrees(run.swing), strict=True)
    rows = [(joint, f"{target:.3g}", f"{reached:.3g}") for joint, target, reached in swings]
    name, label = ("speed", "speed [m/s] over time [s]") if swims else ("power", "electrical power [W] over time [s]")
    return Card(
        f"Twin of {run.robot.name} in {run.medium}: {gait_text(run.gait)}",
        facts,
        " ".join(run.sentences),
        ("joint", "amplitude set [deg]", "reached [deg]"),
        rows,
        lambda: last_beats(run) + curve_svg(run.time, run.data[name], label),
    )


def sea_card(run: SeaRun) -> Card:
    """Show where a run at sea went."""
    title = f"Twin of {run.robot.name} at sea: {gait_text(run.gait)}"
    if run.status == "diverged":
        return Card(title, (), run.divergence)
    way = float(np.hypot(*(run.position[-1, :2] - run.position[0, :2])))
    facts = [
        ("duration", number(run.duration, "s")),
        ("from the start", number(way, "m")),
        ("depth at the end", number(float(run.depth[-1]), "m")),
        ("mean speed ahead", number(float(run.speed.mean()), "m/s")),
        ("mean electrical power", number(float(run.data["power"].mean()), "W")),
        ("heading at the end", number(float(np.degrees(run.heading[-1])), "deg")),
    ]
    return Card(title, facts, picture=lambda: last_beats(run) + _track_svg(run) + _height_svg(run))


def losses_card(losses: Losses) -> Card:
    """Show where the power goes."""
    facts = [("power of the cells", number(losses.power, "W"))]
    facts += [(place, number(losses.at(place), "W")) for place in PLACES]
    rows = [
        (loss.text, number(loss.power, "W"), number(100 * loss.power / losses.power, "%")) for loss in losses.losses
    ]
    bars = [(loss.name, 0.0, 100 * loss.power / losses.power) for loss in losses.losses]
    title, columns = f"Losses of {losses.title}", ("loss", "power", "part")
    return Card(title, facts, columns=columns, rows=rows, picture=lambda: bars_svg(bars, "part of the power [%]"))


def _height_svg(run: SeaRun) -> str:
    """Draw the height of the nose over time."""
    return curve_svg(run.time, -run.depth, "height [m] over time [s]")


def _track_svg(run: SeaRun) -> str:
    """Draw the track of the nose from above, without its swing."""
    east, north = (run.averaged(run.position[:, axis]) for axis in (0, 1))
    return track_svg(east, north, run.duration, "mean of the beat: north [m] over east [m]")


def posture_columns(test: PostureTest) -> dict[str, list[Any]]:
    """Return how each joint group reached its set angle at each frequency, as columns."""
    reach = {(one.joint, one.frequency): one for one in test.reach}
    far = [reach.get((one.joint, one.frequency)) for one in test.held]
    return {
        "frequency_hz": [one.frequency for one in test.held],
        "joint": [one.name for one in test.held],
        "angle_set_deg": [float(np.degrees(one.angle_set)) for one in test.held],
        "settling_s": [np.nan if one.settling is None else one.settling for one in test.held],
        "amplitude_max_deg": [np.nan if one is None else float(np.degrees(one.amplitude_max)) for one in far],
    }


def posture_card(test: PostureTest) -> Card:
    """Show when each joint group settles at its set angle, and the largest that it holds."""
    columns = ("frequency [Hz]", "joint", "set [deg]", "settles [s]", "holds up to [deg]")
    table = zip(*posture_columns(test).values(), strict=True)
    rows = [(number(f), joint, *(number(value) for value in values)) for f, joint, *values in table]
    text = "Settled: within half a degree of the set angle from then on."
    title = f"Posture test of {test.robot.name} in {test.medium}"
    return Card(title, (), text, columns, rows, lambda: last_beats(test.held[0].run))


def dive_card(dive: Dive) -> Card:
    """Show both legs of a dive."""
    columns = ("fins [deg]", "depth rate [cm/s]", "pitch [deg]", "speed [m/s]")
    rows = [
        (
            f"{np.degrees(leg.fins):+z.3g}",
            f"{100 * leg.depth_rate:+z.1f}",
            f"{np.degrees(leg.pitch):+z.1f}",
            number(leg.speed),
        )
        for leg in dive.legs
    ]
    run = dive.run
    title = f"Dive of {run.robot.name}: {gait_text(run.gait)}"
    facts = [("duration", number(run.duration, "s")), ("rate up over rate down", number(dive.symmetry))]
    picture = None if run.status == "diverged" else lambda: last_beats(run) + _height_svg(run)
    return Card(title, facts, " ".join(dive.sentences), columns, rows, picture)


def last_beats(run: TwinRun | SeaRun) -> str:
    """Return the body over the last beats of a run as an animated SVG, with a line that says which."""
    time, frequency = run.time, run.gait.frequency
    if len(time) < 2 or (time[1] - time[0]) * frequency * COARSE > 1:
        return captioned("", f"The body is not drawn: the record has fewer than {COARSE} rows a beat.")
    begin = max(time[0], time[-1] - BEATS / frequency)
    seconds = time[-1] - begin
    instants = np.linspace(begin, time[-1], round(FRAMES * seconds * frequency) + 1)
    columns = np.column_stack([_pose(run), run.data["angle"]])
    rows = np.stack([np.interp(instants, time, column) for column in columns.T], axis=1)
    pose, bends = rows[:, :3], rows[:, 3:]
    lines = body_points(run.robot, pose, bends @ group_shares(run.robot).T)
    shapes = bodies(run.robot, followed(lines, pose[:, 2]))
    step = water_step(run.robot, lines[:, 0], pose[:, 2]) / (seconds * frequency)
    film = film_svg(shapes, step, 1 / frequency, seconds, f"{run.robot.name} from above")
    span = f"{number(begin)} to {number(time[-1], 's')}"
    hinge = "" if run.robot.hinge is None else "; its passive hinge is drawn straight"
    return captioned(film, f"The last {seconds * frequency:.2g} beats from above, {span}, in real time{hinge}.")


def _pose(run: TwinRun | SeaRun) -> Array:
    """Return x, y [m] of the nose and the angle of the head's axis from above [rad] (T, 3)."""
    if isinstance(run, TwinRun):
        return np.column_stack([run.data[name] for name in ("x", "y", "heading")])
    axis = rotation_of(run.attitude)[:, :, 0]
    return np.column_stack([run.position[:, :2], np.unwrap(np.arctan2(axis[:, 1], axis[:, 0]))])
