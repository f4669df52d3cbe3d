"""Kinds of files that users give: a whole file of each, how it is damaged, and the commands that read it."""

import functools
import random
import shutil
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from black_box import head, tick
from mutations.damage import Damage, of_bytes, of_table, of_text
from mutations.judge import answer

ROOT = Path(__file__).parents[2]
EXAMPLES, ROBOTS, TANK = ROOT / "examples", ROOT / "robots", ROOT / "examples/tank"
TANK_FILES = tuple(TANK / name for name in ("tank.toml", "tank.csv", "angles.csv", "poses.csv"))
Make = Callable[[Path], None]  # writes the whole files into a folder


@dataclass(frozen=True)
class Case:
    """A kind of file."""

    name: str
    file: str  # name of the file to damage
    make: Make
    commands: tuple[str, ...]  # that read it: each seed takes the first, and one of the others in turn
    damage: Damage = of_text
    resumes: bool = False  # whether the first command must come to the result that it has with the whole file
    measured: bool = False  # and the file has measurements: the result may also be that before the last of them
    needs: str = ""  # package that is needed
    every: int = 1  # seed that is taken: of kinds whose commands take seconds, only some

    @property
    def there(self) -> bool:
        """Whether the package that is needed is installed."""
        return not self.needs or find_spec(self.needs) is not None


@dataclass(frozen=True)
class Reaction:
    """What the commands made of a damaged file."""

    problems: tuple[str, ...]  # what is wrong, each with the command
    accepted: bool  # whether any command gave an answer
    seconds: float  # of processor, of the longest command


def _copy(*files: Path) -> Make:
    """Return what copies files."""

    def make(folder: Path) -> None:
        for file in files:
            shutil.copy(file, folder)

    return make


def _write(texts: Mapping[str, str], *files: Path) -> Make:
    """Return what writes texts, and copies files."""

    def make(folder: Path) -> None:
        for name, text in texts.items():
            (folder / name).write_text(text)
        _copy(*files)(folder)

    return make


def _run(*commands: str, files: tuple[Path, ...] = (), runs: bool = False) -> Make:
    """Return what runs commands beside copies of files, and maybe of measured runs."""

    def make(folder: Path) -> None:
        _copy(*files)(folder)
        if runs:
            (folder / "runs.csv").write_text(RUNS)
        for command in commands:
            done = answer(command, folder)
            assert done.code in (0, 1), f"{command}: {done}"

    return make


def _measured_gaits(folder: Path) -> None:
    """Begin a tank search, and fill in the speeds of its gaits."""
    _run(f"{ASK} {STATE}", files=MINNOW_FILE)(folder)
    head, *rows = (folder / "gaits.csv").read_text().splitlines()
    place = head.split(",").index("speed_m_s")
    cells = [row.split(",") for row in rows]
    filled = [",".join([*row[:place], f"0.{k + 1}", *row[place + 1 :]]) for k, row in enumerate(cells)]
    (folder / "gaits.csv").write_text("\n".join([head, *filled]) + "\n")


def _black_box(folder: Path) -> None:
    """Write a black box: two boots of 60 ticks."""
    boot = head() + b"".join(tick(k) for k in range(60))
    (folder / "box.bin").write_bytes(boot + boot)


def _radio_log(folder: Path) -> None:
    """Write a radio log of a tank run and a bench test."""
    import hypertuna as ht
    from tank_log import bench_test, tank_run

    fish = ht.load("hypertuna")
    gaits = [ht.Gait.from_degrees(frequency=2, amplitude=(10, 15), phase=(0, lag)) for lag in (0, 40)]
    tank_run(folder / "tank.mcap", fish, gaits)
    bench_test(folder / "bench.mcap", fish)


def _head(path: Path, rows: int) -> str:
    """Return the first rows of a file."""
    return "".join(path.read_text().splitlines(keepends=True)[:rows])


ANGLES = "frequency_hz,amplitude_front_deg,amplitude_middle_deg,amplitude_fin_deg,phase_middle_deg,phase_fin_deg"
RUNS = f"""{ANGLES},speed_m_s,speed_sd_m_s,repeats
1,8,14,20,30,60,0.10,0.003,3
2,8,14,20,30,60,0.21,0.003,3
3,8,14,20,30,60,0.31,0.003,3
2,8,14,20,0,60,0.20,0.003,3
"""
TENSILE = "Engineering Strain;Engineering Stress (MPa)\n" + "".join(
    f"{k / 20:g};{2 * (1 + k / 20 - (1 + k / 20) ** -2) * 0.03:.5g}\n" for k in range(21)
)
SPRING = "mass_kg,arm_m,angle_deg\n" + "".join(f"{k / 100:g},0.1,{k}\n" for k in range(9))
CALIBRATION = "sensor,counts,reference\n" + "".join(
    f"{sensor},{counts},{reference}\n"
    for sensor in ("bend_0", "pressure_3", "current_1", "servo_0")
    for counts, reference in ((1000, -20), (1500, 0.1), (2000, 20))
)
MARKERS = _head(EXAMPLES / "eel/fast.csv", 32)
PLACES = "marker,from_nose_m\n" + "".join(f"{k + 1},{0.61 * k / 11:.4f}\n" for k in range(12))

MINNOW, TUNA = "--robot minnow.toml", "--robot hypertuna.toml --gait unoptimised-0.3"
IDENTIFY = f"identify runs.csv {MINNOW} --free water.drag_normal[3] --starts 1 --threads 1 --validate 0 --json"
OPTIMIZE = f"optimize {MINNOW} --maximize speed --method pso --particles 2 --iterations 4 --json"
SQP = f"optimize {MINNOW} --maximize speed --particles 1 --iterations 2 --json"
PARETO = f"pareto {MINNOW} --population 4 --generations 3 --steps 32 --no-polish --json"
SEEDS = "mission box --duration 0.2 --seeds 0:4 --threads 1 --json"
FLIGHT = "mission box --duration 0.5 --json"
IMPORT = "trials import markers fast.csv --robot rexeel --scale 0.001 --unit px -o out.toml"
NEXT, DESIGN = f"design ask {MINNOW}", "--state design.jsonl"
ASK, STATE = f"optimize ask {MINNOW} --maximize speed --particles 2 -o gaits.csv", "--state state.jsonl"
MINNOW_FILE = (EXAMPLES / "minnow.toml",)
LOG = ("log info m.mcap", "log to-csv m.mcap -o out.csv", "log to-gpx m.mcap -o out.gpx", "log plot m.mcap -o out.svg")
REPLAY = "replay tank.toml --robot hypertuna"


def _journal(name: str, command: str, *, file: str = "j.jsonl", every: int = 1) -> Case:
    """Return the kind of the journal of a command, which must resume to the same result."""
    command = f"{command} --checkpoint j.jsonl"
    make = _run(command, files=MINNOW_FILE, runs=True)
    return Case(name, file, make, (command,), resumes=True, every=every)


CASES = (
    Case(
        "first robot",
        "myfish.toml",
        _copy(EXAMPLES / "myfish.toml"),
        (
            "robot check myfish.toml",
            "swim --robot myfish.toml --json",
            "swim --robot myfish.toml --from-rest 1",
            "swim --robot myfish.toml -o out.nc",
            "robot show myfish.toml",
        ),
    ),
    Case(
        "servo robot",
        "servofish.toml",
        _copy(EXAMPLES / "servofish.toml"),
        (
            "robot check servofish.toml",
            "twin --robot servofish.toml --duration 1",
            "twin --robot servofish.toml --duration 1 -o out.nc",
            "swim --robot servofish.toml --json",
            "range --robot servofish.toml --gait cruise --duration 5",
        ),
    ),
    Case(
        "hydraulic robot",
        "hypertuna.toml",
        _copy(ROBOTS / "hypertuna.toml"),
        (
            "robot check hypertuna.toml",
            f"swim {TUNA} --json",
            f"twin {TUNA} --duration 1",
            f"pump {TUNA}",
            "pump --robot hypertuna.toml --frequency 2",
            "joint bend --robot hypertuna.toml --joint I",
            "posture-test --robot hypertuna.toml --frequency 4 --duration 0.5 --no-limits",
            "mission box --robot hypertuna.toml --duration 0.3",
            f"sweep {TUNA} --frequency 1:2:2 --threads 1 -o out.nc",
            f"range {TUNA} --duration 5",
            "firmware params --robot hypertuna.toml",
        ),
    ),
    Case(
        "fit",
        "out.toml",
        _run(f"{IDENTIFY} -o out.toml", files=MINNOW_FILE, runs=True),
        (
            "robot check out.toml",
            "robot show out.toml",
            "swim --robot out.toml --gait cruise --json",
            "optimize --robot out.toml --maximize speed --robust mean --samples 2 --method pso --particles 2 "
            "--iterations 1",
            "trials check runs.csv --robot out.toml",
        ),
    ),
    Case(
        "steady runs",
        "runs.csv",
        _write({"runs.csv": RUNS}, *MINNOW_FILE),
        (f"trials check runs.csv {MINNOW}", IDENTIFY, f"{IDENTIFY} -o out.toml"),
        of_table,
    ),
    Case(
        "manifest",
        "tank.toml",
        _copy(*TANK_FILES),
        ("trials check tank.toml --robot hypertuna", REPLAY),
        every=2,
    ),
    Case(
        "angles",
        "angles.csv",
        _copy(*TANK_FILES),
        (
            REPLAY,
            "replay angles.csv --robot hypertuna --columns joint_I,joint_II -o out.nc",
            "trials check tank.toml --robot hypertuna",
        ),
        of_table,
        every=2,
    ),
    Case(
        "poses",
        "poses.csv",
        _copy(*TANK_FILES),
        (REPLAY, "trials check tank.toml --robot hypertuna", f"{REPLAY} --json"),
        of_table,
        every=2,
    ),
    Case("markers", "fast.csv", _write({"fast.csv": MARKERS}), (IMPORT,), of_table),
    Case(
        "places",
        "places.csv",
        _write({"fast.csv": MARKERS, "places.csv": PLACES}),
        (f"{IMPORT} --places places.csv",),
        of_table,
    ),
    Case(
        "bench",
        "bench.csv",
        _write({"bench.csv": _head(EXAMPLES / "bench/bench.csv", 10)}),
        ("joint fit bench.csv --robot hypertuna --starts 1 --free lever",),
        of_table,
        every=5,
    ),
    Case("tensile test", "test.csv", _write({"test.csv": TENSILE}), ("joint silicone test.csv",), of_table),
    Case("spring test", "test.csv", _write({"test.csv": SPRING}), ("joint spring test.csv",), of_table),
    Case(
        "calibration", "pairs.csv", _write({"pairs.csv": CALIBRATION}), ("radio calibrate --csv pairs.csv",), of_table
    ),
    Case(
        "mission",
        "lake.toml",
        _copy(ROOT / "missions/lake.toml"),
        (
            "mission lake.toml --duration 0.2",
            "mission lake.toml --duration 0.2 -o out.mcap --gpx out.gpx",
            "mission lake.toml --duration 0.2 --seeds 0:2 --threads 1 -o out.csv",
            "mission lake.toml --duration 0.2 --plot out.svg",
        ),
    ),
    Case("log", "m.mcap", _run(f"{FLIGHT} -o m.mcap"), LOG, of_bytes, needs="foxglove"),
    Case(
        "black box",
        "box.bin",
        _black_box,
        ("log black-box box.bin -o out.mcap", "log black-box box.bin --robot hypertuna --mission lake -o out.mcap"),
        of_bytes,
        needs="foxglove",
    ),
    Case(
        "radio log",
        "tank.mcap",
        _radio_log,
        ("trials check tank.mcap --robot hypertuna",),
        of_bytes,
        needs="pymavlink",
    ),
    Case(
        "radio log of a bench",
        "bench.mcap",
        _radio_log,
        ("joint fit bench.mcap --robot hypertuna --starts 1 --free lever",),
        of_bytes,
        needs="pymavlink",
        every=10,
    ),
    Case(
        "firmware header",
        "out.hpp",
        _run("firmware params -o out.hpp"),
        ("firmware params --check out.hpp",),
    ),
    _journal("journal of a swarm", OPTIMIZE),
    _journal("journal of a gradient search", SQP),
    _journal("journal of a front", PARETO),
    _journal("journal of a fit", IDENTIFY),
    _journal("journal of a posterior", f"{IDENTIFY} --posterior 10", file="j-posterior.jsonl", every=10),
    _journal("journal of a flight", FLIGHT),
    _journal("journal of flights", SEEDS),
    Case(
        "tank search",
        "state.jsonl",
        _run(
            f"{ASK} {STATE}",
            f"optimize tell {STATE} --value 0.1 --value 0.2",
            f"optimize ask {STATE}",
            f"optimize tell {STATE} --value 0.15",
            files=MINNOW_FILE,
        ),
        (f"optimize ask {STATE} --json",),
        resumes=True,
        measured=True,
    ),
    Case(
        "tank design",
        "design.jsonl",
        _run(
            f"{NEXT} {DESIGN}",
            f"design tell {DESIGN} --value 0.1 --value 0.2",
            f"design tell {DESIGN} --value 0.15",
            files=MINNOW_FILE,
        ),
        (f"design ask {DESIGN} --json",),
        resumes=True,
        measured=True,
    ),
    Case(
        "results of a tank search",
        "gaits.csv",
        _measured_gaits,
        (f"optimize tell gaits.csv {STATE} --json", f"optimize ask {STATE}"),
        of_table,
    ),
)


@functools.cache
def whole(case: Case) -> tuple[tempfile.TemporaryDirectory[str], list[Any]]:
    """Return a folder with the whole files of a case, kept to the end, and the results that are right if it resumes."""
    kept = tempfile.TemporaryDirectory()
    folder = Path(kept.name)
    case.make(folder)
    if not case.resumes:
        return kept, []
    file, command = folder / case.file, case.commands[0]
    results, content = [answer(command, folder).result], file.read_bytes()
    lines = content.splitlines(keepends=True)
    for count in range(1, len(lines) if case.measured else 0):
        file.write_bytes(b"".join(lines[:count]))
        results.append(answer(command, folder).result)
    file.write_bytes(content)
    return kept, results


def judged(case: Case, seed: int) -> Reaction:
    """Damage the file of a case by a seed, run commands that read it, and judge their answers."""
    kept, results = whole(case)
    chance = random.Random(f"{case.name} {seed}")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        shutil.copytree(kept.name, folder, dirs_exist_ok=True)
        file = folder / case.file
        file.write_bytes(case.damage(file.read_bytes(), chance))
        first, *others = case.commands
        commands = [first, *others[seed % len(others) :][:1]] if others else [first]
        answers = [(command, answer(command, folder)) for command in commands]
    problems = [f"hypertuna {command}: {one.problem}" for command, one in answers if one.problem]
    if results and not problems and answers[0][1].code != 2 and answers[0][1].result not in results:
        problems.append(f"hypertuna {first}: another result than from the whole file")
    accepted = any(one.code != 2 for _, one in answers)
    return Reaction(tuple(problems), accepted, max(one.seconds for _, one in answers))
