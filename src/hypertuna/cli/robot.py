"""The commands `hypertuna robot new | check | show | keys | image | schema`."""

import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, cast

import typer

from hypertuna.cli import options as opt
from hypertuna.cli import parsing
from hypertuna.cli.console import print_json, print_lines
from hypertuna.cli.emit import emit, refused
from hypertuna.cli.streams import note
from hypertuna.description.drag import NOSES
from hypertuna.description.new import Sizes
from hypertuna.description.plausibility import implausible
from hypertuna.description.reference import Key, json_schema
from hypertuna.description.robot import Entry, Robot, load
from hypertuna.description.schema.body import DRIVES
from hypertuna.description.twin import twin_note, why_no_twin
from hypertuna.display import Table
from hypertuna.errors import InputError, did_you_mean
from hypertuna.io.quantity import counted

robot_app = opt.group("Robot descriptions: begin one, check a file, show a robot, print the format.")

LENGTHS = "Lengths of the links in m, head to tail, separated by commas; instead of --links and --length."
MASS = "Mass of the robot in kg. (default: that of a slender fish of its length, or of its height and width)"
NOSE = f"How the body meets the flow: {'; '.join(f'{word}: {nose.words}' for word, nose in NOSES.items())}."
HEIGHT = "Largest height of the body in m, without fins. (default: that at which it floats)"
WIDTH = "Largest width of the body in m, without fins. (default: that at which it floats)"
CHORD = "Mean chord of the tail fin in m: its area over its span. (default: a fin of 0.15 lengths, narrow in front)"
JOINTS = "Names of the joint groups, head to tail, separated by commas. (default: one for each link behind the head)"
TAILS = ("driven", "passive", "flexible")  # kinds of tail fins

RobotFile = Annotated[
    str, typer.Argument(help="Name of a robot that comes with hypertuna, or path of a TOML file.", show_default=False)
]


@dataclass(frozen=True)
class SizeOptions:
    """Options: a robot's sizes, as its builder measures them."""

    links: Annotated[
        int | None,
        opt.whole_number("--links", "Number of rigid links: the head and one behind each joint. (default: 3)"),
    ] = None
    length: Annotated[
        float | None, opt.number("--length", "m", "Length from nose to tail tip in m. (default: 0.3)")
    ] = None
    lengths: Annotated[str | None, opt.text("--lengths", LENGTHS, "M,M,...")] = None
    mass: Annotated[float | None, opt.number("--mass", "kg", MASS)] = None
    nose: Annotated[str, opt.word("--nose", tuple(NOSES), NOSE)] = "robot"
    height: Annotated[float | None, opt.number("--height", "m", HEIGHT)] = None
    width: Annotated[float | None, opt.number("--width", "m", WIDTH)] = None
    fin_span: Annotated[
        float | None,
        opt.number("--fin-span", "m", "Span of the tail fin in m, tip to tip. (default: the height of the body)"),
    ] = None
    fin_chord: Annotated[float | None, opt.number("--fin-chord", "m", CHORD)] = None

    @property
    def sizes(self) -> Sizes:
        """The sizes that the options give, in SI units."""
        values: dict[str, Any] = {key: value for key, value in vars(self).items() if value is not None}
        if self.lengths is not None:
            if clash := "--links" * (self.links is not None) or "--length" * (self.length is not None):
                raise InputError("must not stand beside --lengths", key=clash, fix="leave it out: it follows")
            values["lengths"] = parsing.numbers(self.lengths, "--lengths", "m")
        return cast(Sizes, values)


@robot_app.command()
@opt.grouped
def new(
    file: Annotated[
        str, typer.Argument(metavar="FILE.toml", help="File to write; its name is the robot's.", show_default=False)
    ],
    size: SizeOptions,
    joints: Annotated[str | None, opt.text("--joints", JOINTS, "NAMES")] = None,
    actuation: Annotated[str, opt.word("--actuation", ("none", *DRIVES), "What drives the joints.")] = "none",
    tail: Annotated[
        str, opt.word("--tail", TAILS, "Tail fin: driven, on a passive hinge, or flexible, a chain of three.")
    ] = "driven",
    sea: Annotated[
        bool, opt.flag("--sea", "Add fins, sections, pilot and wiring: for dive, mission and firmware.")
    ] = False,
    force: opt.Force = False,
) -> None:
    """Write a robot file to start from: a slender fish whose every value is an estimate, and that swims at once."""
    from hypertuna.actuation.new import first_robot
    from hypertuna.io.files import write_atomically

    path = Path(parsing.new_file(parsing.output_file(file, (".toml",), "FILE"), force))
    names = [] if joints is None else [name.strip() for name in joints.split(",")]
    text = first_robot(path.stem, joints=names, actuation=actuation, sea=sea, tail=tail, **size.sizes)
    write_atomically(path, text.encode())
    robot = load(path)
    print_lines(_next_lines(robot))
    _print_twin_note(robot)


def _print_twin_note(robot: Robot) -> None:
    """Print a note if a robot has more joint groups than the twin can simulate."""
    if sentence := twin_note(robot):
        note(sentence)


def _print_spring_note(robot: Robot) -> None:
    """Print a note if hinges have springs that settled beats of the robot's slowest gait, or of 1 Hz, cannot follow."""
    if not robot.hinges:
        return
    import numpy as np  # imported here, since few robots have hinges

    from hypertuna.swimming.beat import DEFAULT_STEPS
    from hypertuna.swimming.yielding import steps_for

    slowest = min((gait.frequency for gait in robot.gaits.values()), default=1.0)
    try:
        steps_for(robot, np.array([slowest]), DEFAULT_STEPS)
    except InputError as error:
        note(f"settled beats refuse {robot.name}: {InputError(error.rule, key=error.key, value=error.value)}")


def _next_lines(robot: Robot) -> Iterator[Any]:
    """Yield the lines that the terminal prints for a written robot, with the next commands."""
    parts = (len(robot.links.name), "link"), (len(robot.joints), "joint group")
    yield f"written: {robot.file}; {', '.join(counted(number, noun) for number, noun in parts)}, all estimates"
    file = shlex.quote(robot.file)
    gait = f" --gait {list(robot.gaits)[-1]}" if len(robot.gaits) > 1 else ""
    yield "next:"
    yield f"  hypertuna swim --robot {file}{gait}"
    if not why_no_twin(robot):
        yield f"  hypertuna twin --robot {file}{gait}"
    if robot.firmware is not None:
        yield f"  hypertuna dive --robot {file}{gait}"
        yield f"  hypertuna firmware params --robot {file}"
    yield f"  hypertuna robot check {file}"
    yield "Replace the estimates by what you measure, and check the file again."


@robot_app.command()
def schema() -> None:
    """Print the JSON Schema of robots/NAME.toml."""
    print_json(json_schema())


@robot_app.command()
def keys(
    part: Annotated[
        str, typer.Argument(metavar="[PART]", help="Part of the names of the keys.", show_default=False)
    ] = "",
    as_json: opt.AsJson = False,
) -> None:
    """List the keys of a robot's file: unit, default, typical value, and how to find it."""
    from hypertuna.description.reference import keys

    found = [key for key in keys() if part in key.key]
    if not found:
        raise InputError("is in no key", key="PART", value=repr(part), fix=did_you_mean(part, (k.key for k in keys())))
    emit(found, record=lambda found: {"keys": [key._asdict() for key in found]}, lines=_key_lines, as_json=as_json)


def _key_lines(found: list[Key]) -> Iterator[Any]:
    """Yield three lines for each key: its unit and meaning, its range and default, and how to find its value."""
    for key in found:
        unit = f" [{key.unit}]" * bool(key.unit)
        yield f"{key.key}{unit}: {key.meaning}", "bold"
        yield f"  {key.value}; default: {key.default or 'required'}{f'; typical: {key.typical}' * bool(key.typical)}"
        yield f"  {key.how}"


@robot_app.command()
def check(robot: RobotFile, as_json: opt.AsJson = False) -> None:
    """Check a robot description, and list unlikely values, estimates, and what has no source."""
    with refused(as_json):
        fish = load(robot)
    _print_twin_note(fish)
    _print_spring_note(fish)
    emit(fish, record=_check_record, lines=_check_lines, as_json=as_json)


@robot_app.command()
def show(robot: RobotFile, as_json: opt.AsJson = False, plot: opt.Plot = None) -> None:
    """Show every value of a robot with its unit and source, estimates marked."""
    emit(
        load(robot),
        record=lambda fish: (
            _summary(fish) | {"values": [entry._asdict() | {"estimate": entry.estimate} for entry in fish.entries()]}
        ),
        lines=_lines,
        plot=plot,
        as_json=as_json,
    )


@robot_app.command()
def image(
    robot: RobotFile,
    output: Annotated[str, opt.file("--output", "the image", ".robot")],
) -> None:
    """Write a robot image: the binary file that programs without Python load through hosts/hypertuna.h."""
    from hypertuna.identification.image import sampled_image
    from hypertuna.io.files import write_atomically

    data = sampled_image(load(robot))
    write_atomically(output, data)
    print_lines([f"written: {output}, {len(data)} bytes"])


def _check_record(robot: Robot) -> dict[str, Any]:
    """Return the JSON record of a check that a description passed."""
    return {"valid": True} | _summary(robot) | {"warnings": implausible(robot)}


def _check_lines(robot: Robot) -> Iterator[Any]:
    """Yield the lines that the terminal prints for a check that a description passed."""
    parts = (len(robot.links.name), "link"), (len(robot.joints), "joint group"), (len(robot.gaits), "gait")
    unlikely = implausible(robot)
    first = (
        f"{counted(len(unlikely), 'value')} {'is' if len(unlikely) == 1 else 'are'} unlikely, but the file is "
        * bool(unlikely)
    )
    yield f"{robot.file}: {first}valid; {', '.join(counted(number, noun) for number, noun in parts)}"
    for sentence in unlikely:
        yield f"unlikely: {sentence}", "yellow"
    tables, keys = _estimates(robot)
    estimates = [f"all of {', '.join(tables)}"] * bool(tables) + [", ".join(keys)] * bool(keys)
    yield f"estimated: {'; '.join(estimates) or 'nothing'}"
    yield f"without a source: {', '.join(robot.unsourced()) or 'nothing'}"


def _estimates(robot: Robot) -> tuple[list[str], list[str]]:
    """Return the tables whose given numbers are all estimates, and the keys of estimates in other tables."""
    entries = [
        (re.sub(r"\[\d+\]", "", entry.key), entry) for entry in robot.entries() if entry.estimate or not entry.default
    ]
    tables: dict[str, None] = {}
    keys: dict[str, None] = {}
    for plain, entry in entries:
        if not (entry.estimate and entry.numeric):
            continue
        names = plain.split(".")
        for part in (".".join(names[:n]) for n in range(1, len(names) + 1)):
            numbers = [e for key, e in entries if e.numeric and f"{key}.".startswith(f"{part}.")]
            if numbers and all(e.estimate for e in numbers):
                (keys if part == plain else tables)[part] = None
                break
        else:
            keys[entry.key] = None
    return list(tables), list(keys)


def _lines(robot: Robot) -> Iterator[Any]:
    """Yield the tables that the terminal shows of a robot: all values, and their sources."""
    sources: dict[str, int] = {}
    yield robot.description, "bold"
    yield f"{robot.file}, sha256 {robot.hash[:12]}; ~ marks an estimate, = a default"
    yield Table(["key", "value", "unit", "source"], [*_rows(robot.entries(), sources)], left=range(4))
    yield Table(["", "sources"], [(f"{number}", source) for source, number in sources.items()], left=(0, 1))


def _rows(entries: tuple[Entry, ...], sources: dict[str, int]) -> Iterator[list[Any]]:
    """Yield the table rows of key, value, unit and source; add new sources to `sources`, numbered in order."""
    from rich.text import Text

    section = ""
    for entry in entries:
        if (start := entry.key.split(".", 1)[0].split("[", 1)[0]) != section:
            section = start
            yield []  # a blank line between tables of the file
        number = sources.setdefault(entry.source, len(sources) + 1) if entry.source else ""
        value = "~" * entry.estimate + "=" * (entry.default and not entry.estimate) + _written_value(entry.value)
        yield [Text(cell, "yellow" * entry.estimate) for cell in (entry.key, value, entry.unit, f"{number}")]


def _written_value(value: Any) -> str:
    """Return the text of a value to six digits, lists with commas, and lists in lists in brackets."""
    if isinstance(value, list):
        return ", ".join(f"[{_written_value(x)}]" if isinstance(x, list) else _written_value(x) for x in value)
    return f"{value:.6g}" if isinstance(value, float) else str(value).lower() if isinstance(value, bool) else str(value)


def _summary(robot: Robot) -> dict[str, Any]:
    """Return the JSON record of a robot: name, hash, links, joint groups, gaits, and keys of estimates."""
    return {
        "name": robot.name,
        "description": robot.description,
        "file": robot.file,
        "hash": robot.hash,
        "links": len(robot.links.name),
        "joint_groups": [group.name for group in robot.joints],
        "gaits": list(robot.gaits),
        "estimates": [entry.key for entry in robot.entries() if entry.estimate],
        "unsourced": list(robot.unsourced()),
    }
