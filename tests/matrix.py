"""Own robots of all sizes and drives, and a short form of every command that takes a robot."""

from __future__ import annotations

import itertools
import random
import shlex
import tomllib
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from hypertuna import _core
from hypertuna.actuation.new import first_robot
from hypertuna.description.robot import Robot, load, parse
from hypertuna.description.schema.body import AXLE, MUSCLES
from hypertuna.description.writer import write_robot
from hypertuna.swimming.gait import named_gait
from hypertuna.swimming.swim import swim
from program import Run

LINKS = tuple(range(2, 21))
DRIVES = ("none", "servo", "tendons", "hydraulic", "mixed")
MADE_OF = {"mixed": "hydraulic"}  # of `robot new`
SEA = (False, True)
TAILS = {"driven": LINKS, "passive": LINKS[1:], "flexible": LINKS[1:8]}  # tails of `robot new`, and their links
MOTORS = 3  # of tails on tendons
FIT = 5  # joint groups with muscles that are long enough for hoses
NEW = "robot new"
# By name; ROBOT is the file, GROUPS the number of joint groups. A second of simulated time, two beats.
COMMANDS = {
    words.partition(" -")[0]: words
    for words in (
        NEW,
        "swim --robot ROBOT --gait cruise --steps 32",
        "sweep --robot ROBOT --gait cruise --frequency 1,2 --steps 32",
        "turn --robot ROBOT --gait cruise --phase PHASES --bias BIAS --steps 32",
        "replay --robot ROBOT angles.csv --columns GROUPS --unit deg",
        "trials check --robot ROBOT runs.csv",
        "identify --robot ROBOT runs.csv --free water.drag_normal=common",
        "optimize --robot ROBOT --maximize speed --method pso --particles 2 --iterations 1",
        "optimize ask --robot ROBOT --maximize speed --particles 2 --state FRESH.state",
        "design ask --robot ROBOT --state FRESH.state",
        "pareto --robot ROBOT --population 4 --generations 1 --no-polish",
        "robot check ROBOT",
        "robot show ROBOT",
        "robot image ROBOT -o OUT.robot",
        "studio ROBOT -o OUT.html",
        "joint spring bench.csv --robot ROBOT --hinge 1 -o OUT.toml",
        "joint bend --robot ROBOT --joint LAST --pressure 0,100",
        "fe geometry --robot ROBOT --joint LAST",
        "pump --robot ROBOT --frequency 2 --amplitude BIAS",
        "range --robot ROBOT --gait cruise --duration 1",
        "twin --robot ROBOT --gait cruise --duration 1",
        "posture-test --robot ROBOT --frequency 2 --angle ANGLES --duration 1 --no-limits",
        "dive --robot ROBOT --gait cruise --duration 8",
        "mission new --robot ROBOT -o OUT-mission.toml --force",
        "mission box --robot ROBOT --duration 1",
        "export mjcf --robot ROBOT -o OUT.xml",
        "export sdf --robot ROBOT -o OUT.sdf",
        "export fmu --robot ROBOT -o OUT.fmu",
        "firmware params --robot ROBOT -o OUT.hpp",
        "firmware wiring --robot ROBOT",
        "hil --robot ROBOT --ticks 100 --firmware no-firmware",
    )
}


# What they need of a robot: a gait, its twin, or fins and a pilot, too; others need a pump, muscles, or more.
GAIT = {"swim", "sweep", "turn", "replay", "trials check", "identify", "optimize", "optimize ask", "pareto"}
GAIT |= {"design ask"}
GAIT |= {"robot check ROBOT", "robot show ROBOT", "robot image ROBOT", "studio ROBOT", "export mjcf", "export sdf"}
TWIN, AT_SEA_ALONE = {"twin", "range", "posture-test"}, {"dive", "mission box"}
BOARD = {"firmware params", "firmware wiring"}


class Case(NamedTuple):
    """A robot and a command."""

    links: int
    drive: str
    sea: bool
    tail: str
    command: str


def all_cases() -> list[Case]:
    """Return the full product."""
    cases = [Case(*case) for case in itertools.product(LINKS, DRIVES, SEA, TAILS, COMMANDS)]
    return [case for case in cases if _possible(case)]


def _possible(case: Case) -> bool:
    """Whether `robot new` may write the robot: one at sea needs a drive, and a mixed one two joint groups."""
    few = case.links not in TAILS[case.tail] or (case.drive == "mixed" and _driven(case.links, case.tail) < 2)
    return case.command == NEW or not (few or (case.drive == "none" and case.sea))


def _driven(links: int, tail: str) -> int:
    """Return the number of driven joints of a robot of `robot new --links`, whose fin may hang on hinges."""
    return links - 1 - (tail != "driven")


def covering_pairs(seed: int = 0) -> list[Case]:
    """Return cases with every pair of links, drive, sea and command at least once; greedy, the same every time."""
    chance, cases = random.Random(seed), []
    left = {pair for case in all_cases() for pair in _pairs(case)}
    while left:
        places, values = min(left, key=repr)
        offered: list[Case] = []
        tries = 20
        while tries > 0 or not offered:
            tries -= 1
            drawn = [chance.choice(list(axis)) for axis in (LINKS, DRIVES, SEA, TAILS, COMMANDS)]
            for place, value in zip(places, values, strict=True):
                drawn[place] = value
            offered += [case for case in [Case(*drawn)] if _possible(case)]
        best = max(offered, key=lambda case: len(left & _pairs(case)))
        cases.append(best)
        left -= _pairs(best)
    return cases


def _pairs(case: Case) -> set[tuple[tuple[int, int], tuple[Any, Any]]]:
    """Return the pairs of values that a case has, with their places."""
    return {((a, b), (case[a], case[b])) for a, b in itertools.combinations(range(len(case)), 2)}


def expected(case: Case) -> bool | None:
    """Whether a command has a result, and not a sentence; None where either may be."""
    oil = case.drive in ("hydraulic", "mixed")
    few = oil or case.drive == "tendons"
    twin = case.drive != "none" and (case.sea or few or _driven(case.links, case.tail) <= _core.MAX_JOINTS)
    board = case.sea and (few or _driven(case.links, case.tail) <= AXLE.on_board)
    needs = ((True, GAIT), (twin, TWIN), (case.sea, AT_SEA_ALONE), (board, BOARD))
    return next((there for there, commands in needs if case.command in commands), None)


def write_case(folder: Path, links: int, drive: str, sea: bool, tail: str = "driven") -> Path:
    """Write the robot of a case and trials of it, once.

    At sea, joints share as many groups as a robot there may have, muscles as many as fit, and tendons those of a few
    motors; others are groups alone.
    """
    home = folder / f"{drive}-{links}-{tail}{'-sea' * sea}"
    file = home / "fish.toml"
    if file.exists():
        return file
    oil = drive in ("hydraulic", "mixed")
    most = (MUSCLES.on_board if oil else _core.MAX_JOINTS) if sea else FIT if oil else links
    most = MOTORS if drive == "tendons" else most
    names = [f"J{j}" for j in range(min(_driven(links, tail), most))]
    options: dict[str, Any] = {"links": links, "sea": sea, "tail": tail, "joints": names}
    text = first_robot("fish", actuation=MADE_OF.get(drive, drive), **options)
    home.mkdir()
    file.write_text(text)
    if drive == "mixed":
        servos = tomllib.loads(first_robot("fish", actuation="servo", **options))
        write_robot(parse(_mixed(tomllib.loads(text), servos)), file)
    _write_trials(home, load(file))
    return file


def _mixed(document: dict[str, Any], servos: dict[str, Any]) -> dict[str, Any]:
    """Return a document of a hydraulic robot whose first joint a servo turns."""
    document["joints"][0] = servos["joints"][0]
    document["servos"][0]["count"] = 2 * (len(document["joints"]) - 1)
    if firmware := document.get("firmware"):
        for pins, fewer in {"servo_pins": 1, "bend_pins": 1, "pressure_pins": 2, "current_pins": 1}.items():
            firmware[pins] = firmware[pins][:-fewer]
    return {key: value for key, value in document.items() if key != "sources"}


def _write_trials(home: Path, robot: Robot) -> None:
    """Write a table of steady runs, a tenth faster than the model, and a series of angles."""
    groups = [group.name for group in robot.joints]
    names = [f"{kind}_{group}_deg" for kind in ("amplitude", "phase") for group in groups]
    rows = []
    for gait in (replace(named_gait(robot, "cruise"), frequency=f) for f in (1.0, 2.0)):
        angles = [*np.degrees(gait.amplitude), *np.degrees(gait.phase)]
        rows.append([gait.frequency, *angles, 1.1 * swim(robot, gait).speed])
    _write_csv(home / "runs.csv", ["frequency_hz", *names, "speed_m_s"], rows)
    _write_csv(home / "bench.csv", ["moment_n_m", "angle_deg"], [[0.01 * k, 5 * k + k % 2] for k in range(1, 6)])
    _write_csv(home / "angles.csv", ["time_s", *groups], [[0.05 * k, *[k % 4] * len(groups)] for k in range(12)])


def _write_csv(path: Path, names: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    path.write_text("".join(",".join(map(str, row)) + "\n" for row in [names, *rows]))


def typed(command: str, file: Path) -> list[str]:
    """Return the words of a command on a robot."""
    groups = [group["name"] for group in tomllib.loads(file.read_text())["joints"]]
    state = file.with_name("search.state")
    state.unlink(missing_ok=True)
    names = {"ROBOT": str(file), "GROUPS": ",".join(groups), "BIAS": ",".join(["2"] * len(groups))}
    names |= {"LAST": f"{len(groups)}", "ANGLES": ",".join(["0.1"] * len(groups))}
    names["PHASES"] = ",".join(f"{20 * j}" for j in range(len(groups)))
    words = shlex.split(COMMANDS[command].replace("OUT", str(file.with_name("out"))).replace("FRESH.state", str(state)))
    here = {name: str(file.with_name(name)) for name in ("angles.csv", "runs.csv", "bench.csv")}
    return [(names | here).get(word, word) for word in words]


def outcome(case: Case, folder: Path, run: Run) -> str:
    """Run a case, check that it has a result or is refused in a sentence, and return which."""
    if case.command == NEW:
        size = ("--links", f"{case.links}", "--actuation", MADE_OF.get(case.drive, case.drive), "--tail", case.tail)
        words = ["robot", "new", str(folder / "new.toml"), "--force", *size, *["--sea"] * case.sea]
    else:
        words = typed(case.command, write_case(folder, *case[:-1]))
    told = answer(words, run)
    assert expected(case) in (None, told == "result"), f"{case}: {told}"
    return told


def answer(words: Sequence[str], run: Run) -> str:
    """Run a command, check that it has a result or is refused in a sentence, and return which."""
    code, output, errors = run(*words)
    if code in (0, 1):
        assert "Traceback" not in errors, errors
        assert output or errors, words
        return "result"
    lines = [line for line in errors.splitlines() if not line.startswith("note: ")]
    assert (code, len(lines)) == (2, 1), f"{words}: exit code {code}, {errors}"
    assert lines[0].startswith("error: "), lines
    assert lines[0].endswith((".", "?")), lines
    return lines[0].removeprefix("error: ")
