"""Names stand for robots, gaits and missions; an argument of a wrong type is one sentence, never a traceback."""

import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna.arguments import FIXES, checked

TANK = Path(__file__).parents[1] / "examples" / "tank"
GAIT = ht.Gait.from_degrees(frequency=2, amplitude=(8, 12), phase=(0, 20))
GRID = ht.Gaits.grid_degrees(frequency=[2], amplitude=[(8, 12)], phase=[(0, 20)])
WRONG = (None, -1.5, "text", [1], {"a": 1}, object(), float("nan"), np.ones(2), b"x")


def base() -> dict[str, tuple[Callable[..., Any], dict[str, Any]]]:
    """Public functions with arguments that are valid, and cheap."""
    fish = ht.load("hypertuna")
    trials = ht.read_trials(TANK / "tank.toml", fish)
    recording = trials.recordings[0]
    replayed = ht.replay_recording(fish, recording)
    both = {"robot": fish, "gait": GAIT}
    track = recording.tracks[0]
    return {
        "load": (ht.load, {"robot": "hypertuna"}),
        "named_gait": (ht.named_gait, {"robot": fish, "name": "turning"}),
        "swim": (ht.swim, both | {"steps": 16, "from_rest": 1.0, "current": (0.0, 0.0)}),
        "sweep": (ht.sweep, {"robot": fish, "gaits": GRID, "steps": 16, "threads": 1, "method": "newton", "beats": 3}),
        "sweep_shards": (
            ht.sweep_shards,
            {
                "robot": fish,
                "gaits": GRID,
                "folder": "a.shards",
                "size": 4,
                "part": (1, 1),
                "steps": 16,
                "threads": 1,
            },
        ),
        "merge_shards": (ht.merge_shards, {"folder": "a.shards"}),
        "gradient": (ht.gradient, both | {"steps": 16}),
        "turn": (ht.turn, {"robot": fish, "gaits": GRID, "steps": 16, "threads": 1}),
        "score_swimmers": (ht.score_swimmers, {"names": ["tunabot"]}),
        "bend": (
            ht.bend,
            {"robot": fish, "joint": "I", "pressure": [0.0, 1e5], "side": "left", "friction": True, "law": "corrected"},
        ),
        "optimize": (
            ht.optimize,
            {"robot": fish, "maximize": "speed", "particles": 2, "iterations": 1, "steps": 16, "method": "pso"}
            | {"seed": 1, "limits": (), "bounds": {"frequency_hz": (1, 2)}},
        ),
        "pareto": (
            ht.pareto,
            {"robot": fish, "objectives": ("speed", "mechanical_power"), "population": 2, "generations": 1, "steps": 16}
            | {"seed": 1, "limits": (), "polish": False, "threads": 1},
        ),
        "gait_limits": (ht.gait_limits, {"robot": fish, "joint_rate": 2.0, "torque": 3.0, "strouhal": (0.2, 0.4)}),
        "read_trials": (ht.read_trials, {"paths": TANK / "tank.csv", "robot": fish}),
        "read_mission": (ht.read_mission, {"path": "box"}),
        "twin": (
            ht.twin,
            both | {"duration": 0.1, "medium": "water", "faults": (), "seed": 0, "closed_loop": True, "start": "rest"},
        ),
        "twin_at_sea": (
            ht.twin_at_sea,
            both
            | {"duration": 0.1, "fins": 0.0, "sea": ht.Sea(), "depth": 2.0, "heading": 0.0, "speed": 0.1, "every": 1},
        ),
        "fly": (ht.fly, {"file": "box", "robot": fish, "duration": 1.0, "seed": 0, "faults": (), "every": 10}),
        "dive": (ht.dive, both | {"duration": 4.0, "angle": 0.3, "depth": 1.0, "seed": 0}),
        "replay": (ht.replay, {"robot": fish, "series": recording.joints, "current": (0.0, 0.0), "step": 0.02}),
        "smooth": (ht.smooth, {"series": recording.joints, "noise": 0.001}),
        "residuals": (ht.residuals, {"robot": fish, "result": replayed, "track": track}),
        "rmse": (ht.rmse, {"robot": fish, "result": replayed, "tracks": [track]}),
        "replay_recording": (ht.replay_recording, {"robot": fish, "recording": recording, "step": 0.02}),
        "compare_recording": (ht.compare_recording, {"robot": fish, "recording": recording, "result": replayed}),
        "Sea": (ht.Sea, {"current": (0.0, 0.1), "bottom": 3.0, "dip": 1.0}),
        "Gait": (ht.Gait, {"frequency": 1.0, "amplitude": (0.1, 0.1), "phase": (0.0, 0.1), "bias": (0.0, 0.0)}),
        "from_degrees": (
            ht.Gait.from_degrees,
            {"frequency": 1.0, "amplitude": (1, 1), "phase": (0, 1), "bias": (0, 0)},
        ),
        "of": (ht.Gaits.of, {"gaits": [GAIT]}),
        "grid": (ht.Gaits.grid, {"frequency": [1], "amplitude": [(0.1, 0.1)], "phase": [(0, 1)], "bias": [(0, 0)]}),
        "grid_degrees": (ht.Gaits.grid_degrees, {"frequency": [1], "amplitude": [(1, 1)], "phase": [(0, 1)]}),
        "plot_sweep": (ht.plot_sweep, {"grid": ht.sweep(fish, GRID, steps=16)}),
        "to_pandas": (ht.to_pandas, {"data": replayed}),
        "studio": (ht.studio, both | {"height": 500}),
        "mjcf": (ht.mjcf, {"robot": fish, "plugin": False, "free": False}),
        "sdf": (ht.sdf, {"robot": fish}),
        "fmu": (ht.fmu, {"robot": fish, "kind": "twin", "fmi": 2, "sea": False}),
        "report": (ht.report, {"results": ht.swim(fish, GAIT), "path": "swim.html"}),
        "read_joints": (
            ht.read_joints,
            {"path": TANK / "angles.csv", "time": "t", "columns": ["a", "b"], "unit": "deg"},
        ),
    }


@pytest.fixture(scope="module")
def calls() -> dict[str, tuple[Callable[..., Any], dict[str, Any]]]:
    return base()


NAMES = [
    "load",
    "named_gait",
    "swim",
    "sweep",
    "sweep_shards",
    "merge_shards",
    "gradient",
    "turn",
    "score_swimmers",
    "bend",
    "optimize",
    "pareto",
    "gait_limits",
    "read_trials",
    "read_mission",
    "twin",
    "twin_at_sea",
    "fly",
    "dive",
    "replay",
    "smooth",
    "residuals",
    "rmse",
    "replay_recording",
    "compare_recording",
    "mjcf",
    "sdf",
    "fmu",
    "Sea",
    "Gait",
    "from_degrees",
    "of",
    "grid",
    "grid_degrees",
    "plot_sweep",
    "to_pandas",
    "studio",
    "report",
    "read_joints",
]


@pytest.mark.parametrize("name", NAMES)
def test_an_argument_of_a_wrong_type_is_one_sentence(
    name: str, calls: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    function, valid = calls[name]
    refused, escaped = 0, []
    for key in valid:
        for wrong in WRONG[name == "fly" and key == "duration" :]:  # None flies to the end
            try:
                function(**valid | {key: wrong})
            except ht.InputError as error:
                refused += 1
                if "\n" in str(error) or "--" in str(error):
                    escaped.append(f"{key}={wrong!r}: {error}")
            except Exception as error:
                escaped.append(f"{key}={wrong!r}: {type(error).__name__}: {error}")
    assert not escaped
    assert refused


def test_every_public_function_is_tried() -> None:
    functions = {name for name in ht.__all__ if inspect.isfunction(getattr(ht, name))}
    slow = {
        "identify",
        "twins",
        "read_tracks",
        "robots",
        "progress_bar",
    }  # identify and read_tracks have tests of their own
    assert functions - slow <= set(NAMES)


def test_names_stand_for_robots_gaits_and_missions() -> None:
    fish = ht.load("hypertuna")
    gait = ht.named_gait(fish, "optimised-0.3")
    assert ht.swim("hypertuna", "optimised-0.3").speed == ht.swim(fish, gait).speed
    assert ht.named_gait("hypertuna", "turning") == ht.named_gait(fish, "turning")
    path = Path(__file__).parents[1] / "examples" / "minnow.toml"
    assert ht.swim(path, "cruise").robot.name == "minnow"
    assert ht.fly("box", "hypertuna", duration=1.0).file.name == "box"
    with pytest.raises(ht.InputError, match=r"gait must be a gait of the robot.*did you mean turning\?"):
        ht.swim("hypertuna", "turnin")
    with pytest.raises(ht.InputError, match="did you mean hypertuna"):
        ht.swim("hypertun", "turning")


def test_the_sentence_names_the_argument_its_kinds_and_the_value() -> None:
    @checked
    def function(number: float | None, pair: tuple[float, float] = (0, 1), names: list[str] | None = None) -> None: ...

    function(np.float64(1), np.ones(2), ["a"])
    function(None)
    for arguments, text in (
        (("3",), r"number must be a number, but is '3' \(str\): write 3 without quotes"),
        ((1, (1, 2, 3)), r"pair must be 2 values, each a number, but is \(1, 2, 3\) \(tuple\)"),
        ((1, (1, 2), "names"), "names must be a list, each text, but is 'names'"),
    ):
        with pytest.raises(ht.InputError, match=text):
            function(*arguments)


def of_kind(kind: str) -> Callable[..., Any]:
    """Return a function of one argument, of a kind."""

    def function(value: Any) -> Any:
        return value

    function.__annotations__ = {"value": kind}
    return checked(function)


# A kind, its words, values of it and values that are not.
KINDS: list[tuple[str, str, list[Any], list[Any]]] = [
    ("float", "a number", [1, 2.5, np.float64(1), np.array(1.0)], ["1", b"1", True, None, [1], 10**400, 1j]),
    ("int", "a whole number", [3, np.int64(3)], [3.0, True, "3", None]),
    ("bool", "True or False", [True, np.True_], [1, None]),
    ("str", "text", ["a", ""], [1, b"a"]),
    ("Path", "a path", [Path("a")], ["a", None]),
    ("Array", "numbers", [1, [1, 2], [[1], [2]]], [[[1], [1, 2]], "1", b"1", None]),
    ("float | None", "a number", [None, 1], ["1"]),
    (
        "Sequence[float]",
        "a list, each a number",
        [[1], (1, 2), [], np.ones(2)],
        ["1", b"1", {1: 1}, iter([1]), 1, ["a"]],
    ),
    ("Iterable[float]", "a list, each a number", [[1], iter([1]), iter(["a"])], ["1", {1: 1}, 1, ["a"]]),  # once only
    ("tuple[float, float]", "2 values, each a number", [(1, 2), np.ones(2)], [(1,), (1, 2, 3), ("a", 1), 1, "12"]),
    ("Mapping[str, float]", "a dict, each value a number", [{"a": 1}, {}], [{1: 1}, {"a": "b"}, [("a", 1)]]),
    ("Callable[[], None]", "a function", [print], [1]),
    ("Literal['a']", "one of its choices", ["a", "b"], [1]),  # the function itself refuses b
    ("float | Sequence[float]", "a number or a list of them", [1, [1]], ["a", ["a"]]),
    ("float | Sequence[str]", "a number or a list, each text", [1, ["a"]], [[1]]),
    ("float | str | Sequence[float | str]", "a number, text or a list of them", [1, "a", ["a", 1]], [None]),
    ("Robot | str | Path", "a Robot, its name or a path", ["a", Path("a")], [1]),
    ("str | Path | Track", "a path or a Track", ["a", Path("a")], [1]),
    ("str | Path", "text or a path", ["a"], [1]),
    ("str | Track", "text or a Track", ["a"], [1]),
    ("Track | float | str", "a Track, a number or text", ["a", 1], [[]]),
    ("Sequence[str | Path]", "a list of paths", [["a", Path("a")]], [1, [1]]),
]


@pytest.mark.parametrize(("kind", "words", "fit", "others"), KINDS, ids=[kind for kind, *_ in KINDS])
def test_a_kind_takes_its_values_and_no_others(kind: str, words: str, fit: list[Any], others: list[Any]) -> None:
    function = of_kind(kind)
    for value in fit:
        assert function(value) is value
    for value in others:
        with pytest.raises(ht.InputError) as caught:
            function(value)
        assert str(caught.value).startswith(f"value must be {words}, but is ")


@pytest.mark.parametrize(
    ("kind", "value", "fix"),
    [
        ("float", " 3.5 ", "write 3.5 without quotes"),
        ("float", "three", "see help(hypertuna.of_kind.<locals>.function)"),
        ("int", 3.0, "write 3"),
        ("int", 3.5, "see help(hypertuna.of_kind.<locals>.function)"),
        ("float", b"3", "see help(hypertuna.of_kind.<locals>.function)"),
        ("str", 1, "write text in quotes"),
        ("str", None, "see help(hypertuna.of_kind.<locals>.function)"),
        ("Sequence[float]", 1, "write [1]"),
        ("Sequence[object]", print, "put it in a list"),
        ("tuple[float, float]", 1, "write value=(a, b)"),
        ("Path", 1, "give the path of a file"),
        ("Sequence[Track]", 1, FIXES["Track"]),
        ("Track | Robot", 1, FIXES["Robot"]),
    ],
)
def test_a_value_of_another_kind_gets_what_to_write(kind: str, value: object, fix: str) -> None:
    with pytest.raises(ht.InputError) as caught:
        of_kind(kind)(value)
    assert caught.value.fix == fix


def test_arguments_without_a_name_and_without_a_kind_are_of_any() -> None:
    @checked
    def function(*numbers: float, other=None, **names: str) -> tuple[Any, ...]:  # type: ignore[no-untyped-def]
        return numbers, other, names

    assert function("a", other=1, key=2) == (("a",), 1, {"key": 2})


# Mistakes of users in Python: a call, and indented below it the sentence.
LINES = (Path(__file__).parent / "mistakes.txt").read_text().splitlines()
MISTAKES = [(call, sentence.strip()) for call, sentence in zip(LINES[::2], LINES[1::2], strict=True)]


@pytest.fixture(scope="module")
def names() -> dict[str, Any]:
    """What the mistakes name."""
    fish = ht.load("hypertuna")
    trials = ht.read_trials(TANK / "tank.toml", fish)
    recording = trials.recordings[0]
    made = {"ht": ht, "fish": fish, "gait": GAIT, "gaits": GRID, "trials": trials, "recording": recording}
    made |= {"swim": ht.swim(fish, GAIT), "swept": ht.sweep(fish, GRID), "track": recording.tracks[0]}
    return made | {"replayed": ht.replay_recording(fish, recording)}


@pytest.mark.parametrize(("call", "sentence"), MISTAKES, ids=[call for call, _ in MISTAKES])
def test_a_mistake_is_a_sentence_with_its_fix(
    call: str, sentence: str, names: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ht.InputError) as caught:
        eval(call, names)
    root = f"{Path(__file__).parents[1]}/"
    assert str(caught.value).replace(root, "") == sentence
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        ("ht.swim(fish)", "swim(): missing a required argument: 'gait': see help(hypertuna.swim)"),
        ("ht.swim(fish, gait, step=8)", "swim(): got an unexpected keyword argument 'step': did you mean steps?"),
        ("ht.swim(fish, gait, 8)", "swim(): too many positional arguments: see help(hypertuna.swim)"),
    ],
)
def test_a_call_that_does_not_fit_names_the_function(call: str, sentence: str, names: dict[str, Any]) -> None:
    with pytest.raises(TypeError) as caught:
        eval(call, names)
    assert str(caught.value) == sentence
