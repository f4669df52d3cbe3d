"""The options that commands share, and how options of each type are declared."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, is_dataclass
from typing import TYPE_CHECKING, Annotated, Any, get_type_hints

import typer

from hypertuna import _core
from hypertuna.cli import parsing
from hypertuna.cli.command import App
from hypertuna.cli.parsing import Bound
from hypertuna.errors import InputError
from hypertuna.ranges import Range, check_choice

if TYPE_CHECKING:
    from hypertuna.description.robot import Robot

# --- how options are declared. Values are read in callbacks, which know the option's name: bad ones are an InputError.


def option(names: Sequence[str], help: str, metavar: str, read: Callable[[str, str], Any]) -> Any:
    """Declare an option whose text `read` turns into a value, given the text and the option's name."""

    def callback(param: typer.CallbackParam, value: Any) -> Any:
        key = max(param.opts, key=len)
        if isinstance(value, list | tuple):
            return [read(part, key) if isinstance(part, str) else part for part in value]
        return read(value, key) if isinstance(value, str) else value

    return typer.Option(*names, help=help, metavar=metavar, parser=_as_typed, callback=callback)


def _as_typed(value: str) -> str:
    """Keep the text for the callback."""
    return value


def group(help: str) -> typer.Typer:
    """Make a group of commands."""
    return App(no_args_is_help=True, help=help)


def _kind(metavar: str, read: Callable[..., Any]) -> Callable[..., Any]:
    """Make a function that declares options of a kind; `read` takes the text, the key, the unit and more."""

    def declare(name: str, unit: str, help: str, **more: Any) -> Any:
        return option((name,), help, metavar, lambda text, key: read(text, key, unit, **more))

    return declare


number = _kind("NUMBER", parsing.number)  # within `limits`
numbers = _kind("NUMBERS", parsing.numbers)  # separated by commas, maybe `count` of them
axis = _kind("RANGE", parsing.axis)  # a value or a range, within `limits`
values = _kind("RANGE,...", parsing.values)  # values and ranges, one after another
ranges = _kind("RANGES", parsing.ranges)  # a value or a range for each of several parts, and all their combinations
interval = _kind("LOW:HIGH", parsing.interval)
bound = _kind("NAME=LOW:HIGH", parsing.bound)
setting = _kind("NAME=VALUE", parsing.setting)


def whole_number(name: str, help: str) -> Any:
    """Declare an option that takes a whole number."""
    return option((name,), help, "INTEGER", parsing.whole_number)


def word(name: str, words: Sequence[str], help: str) -> Any:
    """Declare an option that takes one of several words."""
    return option((name,), help, "|".join(words), lambda text, key: check_choice(text, words, key))


def text(name: str, help: str, metavar: str = "TEXT") -> Any:
    """Declare an option that takes any text."""
    return typer.Option(name, help=help, metavar=metavar)


def file(*names: str, help: str, suffixes: Sequence[str]) -> Any:
    """Declare an option that takes the name of a file to write."""
    return option(names, help, "FILE", lambda text, key: parsing.output_file(text, suffixes, key))


def grouped(command: Callable[..., None]) -> Callable[..., None]:
    """Let a command take groups of options: a parameter whose type is a dataclass stands for the options it holds."""
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

    kind = inspect.Parameter.KEYWORD_ONLY
    listed = [option.replace(kind=kind, annotation=types[name]) for name, option in options.items()]
    called.__signature__ = inspect.Signature(listed)  # type: ignore[attr-defined]  # read by typer
    called.__annotations__ = {option.name: option.annotation for option in listed}
    return called


# --- the robot and its gait

GROUPS = "one per joint group, separated by commas"
RANGE = "A value or a range start:stop:count"
ROBOTS = "(default: the robot's)"

RobotName = Annotated[str, text("--robot", "Name of a robot that comes with hypertuna, or path of its file.")]
GaitName = Annotated[str | None, text("--gait", "A gait of the robot's file; the options below change it.")]
Frequency = Annotated[float | None, number("--frequency", "Hz", "Beat frequency in Hz.")]
Amplitude = Annotated[Sequence[float] | None, numbers("--amplitude", "degrees", f"Amplitudes in degrees, {GROUPS}.")]
Phase = Annotated[
    Sequence[float] | None, numbers("--phase", "degrees", f"Lags behind the first group in degrees, {GROUPS}.")
]
Bias = Annotated[Sequence[float] | None, numbers("--bias", "degrees", f"Mean angles in degrees, {GROUPS}.")]
Frequencies = Annotated[Sequence[tuple[float]] | None, ranges("--frequency", "Hz", f"{RANGE} in Hz.")]
Amplitudes = Annotated[
    list[Any] | None,
    ranges("--amplitude", "degrees", f"{RANGE} per joint group in degrees; repeat it for each level."),
]
Phases = Annotated[
    Sequence[tuple[float, ...]] | None,
    ranges("--phase", "degrees", f"{RANGE} per joint group in degrees: lag behind the first group."),
]
Biases = Annotated[
    Sequence[tuple[float, ...]] | None,
    ranges("--bias", "degrees", f"{RANGE} per joint group in degrees: mean angle."),
]
JointLaw = Annotated[str | None, text("--joints", f"ideal or bandwidth. {ROBOTS}")]
Areas = Annotated[str | None, text("--areas", f"consistent or as-printed. {ROBOTS}")]
LAWS = ", ".join(law for law, _ in _core.water_laws())
WaterLaw = Annotated[str | None, text("--water", f"Water law: {LAWS}. {ROBOTS}")]


@dataclass(frozen=True)
class RobotOptions:
    """A robot and its model."""

    robot: RobotName
    joints: JointLaw = None
    areas: Areas = None
    water: WaterLaw = None

    def load(self) -> Robot:
        """Read the robot."""
        from hypertuna.description.robot import load

        if not self.robot:
            raise InputError("is missing", key="--robot", fix="give a robot's name or the path of its file")
        return load(self.robot).using(joints=self.joints, areas=self.areas, water=self.water)


Joint = Annotated[str, text("--joint", "Name of the joint group, or its number from the head.")]
Side = Annotated[str, text("--side", "Side under pressure, left or right; a bend toward it is positive.")]

# --- the run

Steps = Annotated[int, whole_number("--steps", "Runge-Kutta steps per beat.")]
Threads = Annotated[int | None, whole_number("--threads", "Number of threads. (default: all processors)")]
Duration = Annotated[float, number("--duration", "seconds", "Duration of the run in s.")]
Medium = Annotated[str, word("--medium", ("water", "air"), "What the robot is in: water or air.")]
Temperature = Annotated[float | None, number("--temperature", "C", f"Oil temperature in degrees C. {ROBOTS}")]
# Oil hardly passes thinner lines, and wider ones swing faster than the twin steps.
BORES = Range(min=1.0, max=20.0, unit="mm")
Bore = Annotated[
    float | None, number("--line-bore", "mm", f"Inner diameter of all oil lines in mm. {ROBOTS}", limits=BORES)
]
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
Loss = Annotated[str, text("--loss", "soft_l1, linear, huber or cauchy.")]
Starts = Annotated[int, whole_number("--starts", "Number of searches, each from another start.")]

MAX_PRESSURES = 10_000  # of one call: more add nothing, and take minutes
PRESSURES = Range(max=2000.0)  # kPa: beyond any actuator


def _pressures(text: str, key: str) -> list[float]:
    """Read gauge pressures [kPa]."""
    pressures = parsing.values(text, key, "kPa", limits=PRESSURES)
    if len(pressures) > MAX_PRESSURES:
        rule, fix = f"must be at most {MAX_PRESSURES} pressures", "ask for fewer; 100 make a smooth curve"
        raise InputError(rule, key=key, value=f"{len(pressures)}", fix=fix)
    return pressures


Pressures = Annotated[
    Sequence[float],
    option(("--pressure",), "Rising gauge pressures in kPa: numbers or start:stop:count.", "RANGE", _pressures),
]

# --- what is written

FIGURES = (".svg", ".png", ".pdf")
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object.")]
Plot = Annotated[str | None, file("--plot", help="Write the plot to this .svg, .png or .pdf file.", suffixes=FIGURES)]
TableOutput = Annotated[
    str | None,
    file("-o", "--output", help="Write the data to this .nc or .csv file.", suffixes=(".nc", ".csv")),
]
RobotOutput = Annotated[
    str | None, file("-o", "--output", help="Write the resulting robot to this .toml file.", suffixes=(".toml",))
]


@dataclass(frozen=True)
class Files:
    """What is written, as `emit` takes it."""

    plot: Plot = None
    output: TableOutput = None
    as_json: AsJson = False


NO_FILES = Files()
