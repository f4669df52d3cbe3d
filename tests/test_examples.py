"""The examples run as a user runs them, in a folder of their own, and show what they say."""

import math
import runpy
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import hypertuna as ht
from hypertuna.actuation.new import first_robot

EXAMPLES = Path(__file__).parents[1] / "examples"


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """Run an example in an empty folder and return its names."""
    monkeypatch.chdir(tmp_path)
    return lambda name: runpy.run_path(str(EXAMPLES / name))


def test_every_example_is_tested() -> None:
    tested = Path(__file__).read_text()
    missing = [path.name for path in EXAMPLES.iterdir() if path.is_file() and path.name not in tested]
    assert not missing


def test_swim(run: Any, tmp_path: Path) -> None:
    assert run("swim.py")["swim"].settled
    assert (tmp_path / "swim.svg").stat().st_size > 10_000


def test_phases(run: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert bool(run("phases.py")["found"].settled.all())
    printed = capsys.readouterr().out
    assert "small amplitude: fastest at a phase difference of 20 deg" in printed  # as the paper found, section III.D
    assert "large amplitude: fastest at a phase difference of 40 deg" in printed
    assert (tmp_path / "phases.svg").stat().st_size > 10_000


def test_own_robot(run: Any) -> None:
    names = run("own_robot.py")
    assert names["faster"].settled
    assert names["faster"].speed > 1.02 * names["swim"].speed
    # What is printed for one degree more is the derivative; a central difference of half a degree agrees with it.
    start, half = names["swim"].gait, math.radians(0.5)
    speeds = [
        ht.swim(names["fish"], replace(start, amplitude=(start.amplitude[0] + side * half, *start.amplitude[1:]))).speed
        for side in (1, -1)
    ]
    assert speeds[0] - speeds[1] == pytest.approx(2 * half * names["derivative"]["gait.amplitude[0]"], rel=1e-3)


@pytest.mark.parametrize("file", ["minnow.toml", "hypertuna-strong.toml"])
def test_the_example_robot_is_complete(file: str) -> None:
    assert ht.load(EXAMPLES / file).unsourced() == ()


@pytest.mark.parametrize(
    ("file", "actuation", "options"),
    [
        ("myfish.toml", "none", {"links": 3, "length": 0.3, "mass": 0.85}),
        ("servofish.toml", "servo", {"links": 3, "length": 0.3, "mass": 0.85}),
        ("tendonfish.toml", "tendons", {"links": 5, "joints": ["tail"], "length": 0.3, "mass": 0.85}),
        ("eel.toml", "servo", {"links": 11, "length": 0.9, "height": 0.07, "width": 0.06, "fin_span": 0.08}),
    ],
)
def test_first_robots_are_what_robot_new_writes(file: str, actuation: str, options: dict[str, Any]) -> None:
    text = first_robot(Path(file).stem, actuation=actuation, **options)
    assert (EXAMPLES / file).read_text() == text, "write it again: hypertuna robot new, as docs/start says"


def test_the_eel_swims_with_ten_servos_as_its_ideal_joints_do_at_their_swings() -> None:
    """The twin's bends, as harmonics, make the settled beat that the twin swims: within 5 %."""
    eel = ht.load(EXAMPLES / "eel.toml")
    run = ht.twin(eel, "cruise", duration=12)
    beat = ht.swim(eel, ht.Gait(run.gait.frequency, tuple(run.swing), tuple(run.phase - run.phase[0])))
    assert len(eel.joints) == 10
    assert run.speed == pytest.approx(beat.speed, rel=0.05)


def test_plant_controller(run: Any) -> None:
    names = run("plant_controller.py")
    assert names["bends"] == pytest.approx(names["AMPLITUDE"], rel=0.1)
    assert names["distance"] > 1
