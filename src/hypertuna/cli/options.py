"""The options that commands share, and how options of each type are declared."""

from __future__ import annotations

import contextlib
import functools
import inspect
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, is_dataclass
from typing import TYPE_CHECKING, Annotated, Any, get_type_hints

import typer

from hypertuna import _core
from hypertuna.cli import parsing
from hypertuna.cli.command import App
from hypertuna.cli.parsing import Bound
from hypertuna.cli.streams import note
from hypertuna.errors import InputError
from hypertuna.ranges import Range, check_choice

if TYPE_CHECKING:
    from hypertuna.description.robot import Robot

# --- how options are declared. A callback reads the value: it knows the option's name, for the InputError of a bad one.


def option(names: Sequence[str], help: str, metavar: str, read: Callable[[str, str], Any], **more: Any) -> Any:
    """Declare an option; `read` turns the typed text into a value, and gets the option's name for errors."""

    def callback(param: typer.CallbackParam, value: Any) -> Any:
        key = max(param.opts, key=len)
        if isinstance(value, list | tuple):
            return [read(part, key) if isinstance(part, str) else part for part in value]
        return read(value, key) if isinstance(value, str) else value

    return typer.Option(*names, help=help, metavar=metavar, parser=_as_typed, callback=callback, **more)


def _as_typed(value: str) -> str:
    """Return an option's text unchanged, for its callback to read."""
    return value


def group(help: str) -> typer.Typer:
    """Return an empty group of commands with a help text."""
    return App(no_args_is_help=True, help=help)


SYMBOLS = {"degrees": "deg", "seconds": "s", "C": "degC", "percent": "%", "N m": "N*m"}  # of units, in metavars
SYMBOLS |= dict.fromkeys(("parts of 1", "parts of one", "m/s per J/(kg m)", "deg, kPa or A", "figures, 0.475 say"), "1")
SYMBOLS |= {"m, m and degrees": "m,m,deg"}


def _kind(form: str, read: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function that declares options of a form; `read` takes the text, the key, the unit and more.

    In the metavar `form`, UNIT stands for the symbol of the unit, or for NUMBER without one.
    """

    def declare(name: str, unit: str, help: str, **more: Any) -> Any:
        symbol = SYMBOLS.get(unit, unit)
        metavar = symbol if "," in symbol else form.replace("UNIT", "NUMBER" if symbol == "1" else symbol)
        return option((name,), help, metavar, lambda text, key: read(text, key, unit, **more))

    return declare


number = _kind("UNIT", parsing.number)  # a number within `limits`
numbers = _kind("UNIT,...", parsing.numbers)  # numbers separated by commas: `count` of them, if given
values = _kind("UNIT,...", parsing.values)  # a list of values and ranges, joined, within `limits`
ranges = _kind("UNIT,...", parsing.ranges)  # a value or range per part; gives all combinations
interval = _kind("LOW:HIGH", parsing.interval)
bound = _kind("NAME=LOW:HIGH", parsing.bound)
setting = _kind("NAME=VALUE", parsing.setting)


def whole_number(name: str, help: str) -> Any:
    """Declare an option that takes a whole number."""
    return option((name,), help, "N", parsing.whole_number)


def word(name: str, words: Sequence[str], help: str) -> Any:
    """Declare an option that takes one of several words, which the shell completes."""
    declared = option((name,), help, f"[{'|'.join(words)}]", lambda text, key: check_choice(text, words, key))
    declared.autocompletion = lambda incomplete: starting(words, incomplete)
    return declared


def starting(words: Sequence[str], incomplete: str) -> list[str]:
    """Return the words that begin with the incomplete one."""
    return [word for word in words if word.startswith(incomplete)]


def text(name: str, help: str, metavar: str = "TEXT", **more: Any) -> Any:
    """Declare an option that takes any text."""
    return typer.Option(name, help=help, metavar=metavar, **more)


def flag(name: str, help: str) -> Any:
    """Declare an option without a value."""
    return typer.Option(name, help=help)


def file(name: str, what: str, *suffixes: str) -> Any:
    """Declare an option that takes the name of a file to write."""
    help = f"Write {what} to this {' or '.join(', '.join(suffixes).rsplit(', ', 1))} file."
    names = ("-o", name) if name == "--output" else (name,)
    return option(names, help, "FILE", lambda text, key: parsing.output_file(text, suffixes, key))


def file_or_shards(help: str, *suffixes: str) -> Any:
    """Declare --output, which takes the name of a file, or of a folder of shards, to write."""

    def read(text: str, key: str) -> str:
        if text.rstrip("/").endswith(SHARDS):
            return parsing.shard_folder(text.rstrip("/"), key)
        return parsing.output_file(text, (*suffixes, SHARDS), key)

    return option(("-o", "--output"), help, "FILE", read)


def grouped(command: Callable[..., None]) -> Callable[..., None]:
    """Return a command with each parameter of a dataclass type replaced by that dataclass's fields as options."""
    types: dict[str, Any] = get_type_hints(command, include_extras=True)
    groups: dict[str, Any] = {name: kind for name, kind in types.items() if is_dataclass(kind)}
    options: dict[str, inspect.Parameter] = {}
    for name, parameter in inspect.signature(command).parameters.items():
        if name in groups:
            types |= get_type_hints(groups[name], include_extras=True)
            options |= inspect.signature(groups[name]).parameters
        else:
            options[name] = parameter

    @functools.wraps(command)
    def called(**values: Any) -> None:
        for name, group in groups.items():
            values[name] = group(**{field.name: values.pop(field.name) for field in fields(group)})
        command(**values)

    flat = [one.replace(kind=one.KEYWORD_ONLY, annotation=types[name]) for name, one in options.items()]
    called.__signature__ = inspect.Signature(flat)  # type: ignore[attr-defined]  # read by typer
    called.__annotations__ = {option.name: option.annotation for option in flat}
    return called


# --- the robot and its gait

RANGE, GRID = "values and ranges START:STOP:COUNT, separated by commas", "Commands that swim a grid (sweep, turn) take"
GROUPS = f"one per joint group, separated by commas. {GRID} ranges START:STOP:COUNT, and several levels"
ROBOTS = "(default: the robot's)"
ROBOT = "hypertuna"  # default, without --robot and HYPERTUNA_ROBOT


def offered_robots(incomplete: str) -> list[str]:
    """Return the names of robots that begin with the incomplete one."""
    from hypertuna.description.robot import robots

    return starting(robots(), incomplete)


def offered_files(incomplete: str, suffixes: Sequence[str]) -> list[str]:
    """Return the files with one of the suffixes whose paths begin with the incomplete one."""
    folder, name = os.path.split(incomplete)
    with contextlib.suppress(OSError):
        matches = [entry.name for entry in os.scandir(folder or ".") if entry.name.endswith(tuple(suffixes))]
        return [os.path.join(folder, entry) for entry in starting(sorted(matches), name)]
    return []


def offered_gaits(context: typer.Context, incomplete: str) -> list[str]:
    """Return the gaits that begin with the incomplete name, of the robot typed earlier on the line."""
    from hypertuna.description.robot import load

    named = [*context.args, context.params.get("robot") or ROBOT]  # arguments that are not yet parsed are in `args`
    with contextlib.suppress(InputError):
        return starting([*load(named[0]).gaits], incomplete)
    return []


def _keys(context: typer.Context, incomplete: str) -> list[str]:
    """Return the keys without spaces that begin with the incomplete one, of the robot typed earlier on the line."""
    from hypertuna.description.changes import settable
    from hypertuna.description.robot import load

    with contextlib.suppress(InputError):
        keys = settable(load(context.params.get("robot") or ROBOT))
        return [f"{key}=" for key in starting(keys, incomplete) if " " not in key]
    return []


def _change(text: str, key: str) -> tuple[str, Any]:
    """Return key and value from KEY=VALUE of a robot's file."""
    from hypertuna.description.changes import toml_value

    name, value = parsing.pair(text, key, "KEY=VALUE")
    return name, toml_value(value)


def robot_name(help: str = "Name of a robot that comes with hypertuna, or path of its file.", **more: Any) -> Any:
    """Declare --robot."""
    return text("--robot", help, "ROBOT", autocompletion=offered_robots, **more)


RobotName = Annotated[str, robot_name(envvar="HYPERTUNA_ROBOT")]
Changes = Annotated[
    list[Any] | None,
    option(
        ("--set",),
        "Value of a key of the robot's file, such as joints.II.line.bore_m=0.005.",
        "KEY=VALUE",
        _change,
        autocompletion=_keys,
    ),
]
GaitName = Annotated[
    str | None,
    text("--gait", "A gait of the robot's file; the options below change it.", "NAME", autocompletion=offered_gaits),
]
Frequency = Annotated[
    Sequence[tuple[float]] | None,
    option(
        ("--frequency",),
        f"Beat frequency. {GRID} {RANGE}.",
        "Hz",
        lambda text, key: [(value,) for value in parsing.values(text, key, "Hz")],
    ),
]
Amplitude = Annotated[list[Any] | None, ranges("--amplitude", "degrees", f"Amplitudes, {GROUPS}.")]
Phase = Annotated[list[Any] | None, ranges("--phase", "degrees", "Lags behind the first joint group.")]
Bias = Annotated[list[Any] | None, ranges("--bias", "degrees", "Mean angles of the joint groups.")]
LAWS = [law for law, _ in _core.water_laws()]  # names of water laws
JointLaw = Annotated[str | None, word("--joints", ("ideal", "bandwidth"), f"Model of the joints. {ROBOTS}")]
Areas = Annotated[str | None, word("--areas", ("consistent", "as-printed"), f"Areas of the lumped law. {ROBOTS}")]
WaterLaw = Annotated[str | None, word("--water", LAWS, f"Water law. {ROBOTS}")]


@dataclass(frozen=True)
class RobotOptions:
    """Options: a robot, maybe with changed values."""

    robot: RobotName = ROBOT
    changes: Changes = None

    def load(self, output: str | None = None) -> Robot:
        """Read the robot; `output` is a robot file to write, which must not be the robot's own."""
        from hypertuna.description.changes import changed
        from hypertuna.description.provenance import robot_path
        from hypertuna.description.robot import load

        if not self.robot:
            raise InputError("is missing", key="--robot", fix="give a robot's name or the path of its file")
        robot = load(self.robot)
        if output is not None and os.path.exists(output) and os.path.samefile(output, robot_path(robot.file)):
            rule = "must not be the file that the robot is read from"
            raise InputError(rule, key="--output", value=output, fix="give another name")
        return changed(robot, dict(self.changes or []))


@dataclass(frozen=True)
class MissionRobot(RobotOptions):
    """Options: a robot, instead of the one that a mission file names, maybe with changed values."""

    robot: Annotated[str, robot_name("Robot that swims the mission. (default: that of the mission file)")] = ""


@dataclass(frozen=True)
class ModelOptions(RobotOptions):
    """Options: a robot, maybe with changed values and other laws of its model."""

    joints: JointLaw = None
    areas: Areas = None
    water: WaterLaw = None

    def load(self, output: str | None = None) -> Robot:
        """Read the robot, with the laws that the options choose."""
        return super().load(output).using(joints=self.joints, areas=self.areas, water=self.water)


def with_rigid_hinge(robot: Robot, where: str = "here") -> Robot:
    """Return a robot unchanged, and print a note that the command leaves its hinges rigid."""
    for hinge in robot.hinges:
        rigid = "rigid and straight" if hinge.rest else "rigid"
        note(f"the hinge of link {hinge.link} stays {rigid} {where}: `swim` bends it.")
    return robot


Joint = Annotated[str, text("--joint", "Name of the joint group, or its number from the head.", "JOINT")]
Side = Annotated[str, word("--side", ("left", "right"), "Side under pressure; a bend toward it is positive.")]

# --- the run

Cluster = Annotated[
    str | None,
    text(
        "--cluster",
        "Compute on the workers of this Dask scheduler (tcp://HOST:8786, or its scheduler file).",
        "ADDRESS",
    ),
]


@dataclass(frozen=True)
class Places:
    """Options: where independent cases are computed, on a cluster or in shards."""

    cluster: Cluster = None
    shard: Annotated[
        Any,
        option(
            ("--shard",), "Compute every N-th shard only, from the I-th: job I of an array of N.", "I/N", parsing.share
        ),
    ] = None
    shard_size: Annotated[
        int | None,
        whole_number(
            "--shard-size", "Results per shard. (default: of gaits a 64th of all, from 256 to 131072; of others 1)"
        ),
    ] = None


NO_PLACES = Places()
Steps = Annotated[int, whole_number("--steps", "Runge-Kutta steps per beat.")]
Threads = Annotated[int | None, whole_number("--threads", "Number of threads. (default: all processors)")]
Duration = Annotated[float, number("--duration", "seconds", "Duration of the run.")]
Medium = Annotated[str, word("--medium", ("water", "air"), "Medium around the robot.")]
Temperature = Annotated[float | None, number("--temperature", "C", f"Oil temperature. {ROBOTS}")]
# Oil hardly passes thinner lines; in wider ones it oscillates faster than the twin's time step resolves.
BORES = Range(min=1.0, max=20.0, unit="mm")
Bore = Annotated[float | None, number("--line-bore", "mm", f"Inner diameter of all oil lines. {ROBOTS}", limits=BORES)]
Seed = Annotated[int, whole_number("--seed", "Seed of the random numbers: the same seed gives the same result.")]
Checkpoint = Annotated[
    str | None, text("--checkpoint", "Keep a journal in this file; the same command resumes from it.", "FILE")
]
Bounds = Annotated[
    list[Bound] | None,
    bound(
        "--bounds",
        "Hz or degrees",
        "Bounds of a gait parameter, such as frequency_hz=1:4 or phase_II_deg=0:90; repeatable.",
    ),
]
Loss = Annotated[str, word("--loss", ("soft_l1", "linear", "huber", "cauchy"), "Loss of the residuals.")]
Starts = Annotated[int, whole_number("--starts", "Number of searches, each from another start.")]

MAX_PRESSURES = 10_000  # of one call: more take minutes and resolve nothing new
PRESSURES = Range(max=2000.0)  # kPa, above that of any actuator


def _pressures(text: str, key: str) -> list[float]:
    """Return gauge pressures [kPa] from a text of numbers and ranges."""
    pressures = parsing.values(text, key, "kPa", limits=PRESSURES)
    if len(pressures) > MAX_PRESSURES:
        rule, fix = f"must be at most {MAX_PRESSURES} pressures", "ask for fewer; 100 make a smooth curve"
        raise InputError(rule, key=key, value=f"{len(pressures)}", fix=fix)
    return pressures


Pressures = Annotated[
    Sequence[float],
    option(("--pressure",), f"Rising gauge pressures: {RANGE}.", "kPa,...", _pressures),
]

# --- what is written

SHARDS = ".shards"  # suffix of a folder of shards
FIGURES = (".svg", ".png", ".pdf")  # endings of plots' files
AsJson = Annotated[bool, flag("--json", "Print one JSON object.")]
Plot = Annotated[str | None, file("--plot", "the plot", *FIGURES)]
Manifest = Annotated[str, file("--output", "the manifest", ".toml")]
TableOutput = Annotated[str | None, file("--output", "the data", ".nc", ".csv")]
ShardsOutput = Annotated[
    str | None,
    file_or_shards("Write the data to this .nc or .csv file, or to this .shards folder, which resumes.", ".nc", ".csv"),
]
Force = Annotated[bool, flag("--force", "Replace a file that exists.")]
RobotOutput = Annotated[str | None, file("--output", "the resulting robot", ".toml")]


@dataclass(frozen=True)
class Files:
    """Options of the files to write and of --json, as `emit` takes them."""

    plot: Plot = None
    output: TableOutput = None
    as_json: AsJson = False


NO_FILES = Files()


@dataclass(frozen=True)
class ShardFiles(Files):
    """Options of the files to write, which may be a folder of shards, and of --json."""

    output: ShardsOutput = None


NO_SHARD_FILES = ShardFiles()
