"""What holds for every kind of trial: all lists follow from `KINDS`."""

from __future__ import annotations

import ast
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import hypertuna as ht
from hypertuna import _core
from hypertuna.description.robot import Robot
from hypertuna.identification.coefficients import free
from hypertuna.identification.experiment import NAMES, experiment
from hypertuna.identification.names import split_names
from hypertuna.identification.prediction import predict, weighted
from hypertuna.identification.residuals import LABELS, errors
from hypertuna.swimming.model import core_model
from hypertuna.trials.decay import Glide, YawDecay
from hypertuna.trials.kind import Kind
from hypertuna.trials.kinds import KINDS, QUANTITIES, kind_of
from hypertuna.trials.manifest import Manifest, parse_manifest
from hypertuna.trials.numbers import HeldThrust, PowerRun, Tow, TurnRun
from hypertuna.trials.trials import Trials, digest, split
from synthetic import grid, steady, swims

TANK = Path(__file__).parents[2] / "examples" / "tank"
SOURCE = Path(ht.__file__).parent
BETWEEN = 0.0013  # s, time offset with which no frame is at a step of the replay, where poses have a kink
# What each kind tells of the water: a straight body that goes ahead knows no drag across, a held head neither.
TOLD = {
    "tows": "water.friction",
    "thrusts": "water.drag[1-6],water.friction",
    "glides": "water.friction,water.added_mass[0]",
    "yaw_decays": "water.drag[0,1-6],water.added_mass[7]",
}
MANIFESTS = ("tank.toml", "forces.toml", "turns.toml")


def number_runs(robot: Robot, kind: Kind[Any], made: type[Any], runs: list[dict[str, Any]]) -> Trials:
    """Runs of one number each that the robot would have made."""
    blank = tuple(made(f"{kind.key} {k}", 1.0, file="synthetic.csv", **run) for k, run in enumerate(runs))
    computed = predict(experiment(robot, Trials(blank)), [], gradient_steps=None).computed.tolist()
    return Trials(tuple(replace(run, value=value) for run, value in zip(blank, computed, strict=True)))


def decays(robot: Robot, made: type[Any], first: tuple[float, ...]) -> Trials:
    """Decays from first values, computed at more steps than a kind takes."""
    time, steps = np.linspace(0, 2, 41), 4000
    kind = next(kind for kind in KINDS if kind.trial is made)
    found = []
    for value in first:
        twist = value * kind.begin(robot)
        still = np.zeros((2 * steps + 1, len(robot.links.name), 3))
        made_by = _core.advance(core_model(robot), still, step=2 / steps, twist=twist, pose=np.zeros(3))["twist"]
        values = np.abs(made_by[:: steps // 40, kind.axis])
        found.append(made(f"{kind.key} from {value:g}", time, values, file="synthetic.csv"))
    return Trials(tuple(found))


def samples(kind: Kind[Any], robot: Robot) -> Trials:
    """Trials of one kind that the robot would have made: a new kind adds its own."""
    made = {
        "steady": lambda: steady(robot, grid([1, 3], [(8, 15), (16, 25)], [0, 40])),
        "recordings": lambda: swims(robot, runs=3),
        "tows": lambda: number_runs(robot, kind, Tow, [{"u": u} for u in (0.1, 0.2, 0.4)]),
        "thrusts": lambda: number_runs(
            robot, kind, HeldThrust, [{"gait": g, "u": u} for g in grid([1, 3], [(8, 15)], [0, 40]) for u in (0.0, 0.2)]
        ),
        "powers": lambda: number_runs(
            robot, kind, PowerRun, [{"gait": g} for g in grid([1, 2, 3], [(8, 15)], [0, 40])]
        ),
        "turns": lambda: number_runs(
            robot, kind, TurnRun, [{"gait": replace(g, bias=(0.1, 0.1))} for g in grid([1, 2, 3], [(8, 15)], [0, 40])]
        ),
        "glides": lambda: decays(robot, Glide, (0.5, 0.3, 0.2)),
        "yaw_decays": lambda: decays(robot, YawDecay, (2.0, 1.0, 0.5)),
    }
    return made[kind.key]()


@pytest.fixture(params=KINDS, ids=[kind.key for kind in KINDS])
def kind(request: pytest.FixtureRequest) -> Kind[Any]:
    """Each kind."""
    return request.param


def test_a_kind_meets_its_own_prediction(kind: Kind[Any], tuna: Robot) -> None:
    """Without free coefficients the residuals of trials that the robot made are zero, but for the steps in time."""
    trials = samples(kind, tuna)
    data = experiment(tuna, trials)
    found = predict(data, [], gradient_steps=None)
    assert not found.failed.any()
    assert not found.unstable.any()
    assert np.abs(weighted(data, found, dict.fromkeys(NAMES, 1.0))[0]).max() < 1e-3
    shown = errors(data, found)
    bends = {"bend_amplitude_relative", "bend_lag_deg"}  # of hinges, which the robot lacks
    assert set(shown.rms) == {quantity.key for quantity in kind.quantities} - bends
    assert [run["run"] for run in shown.runs] == list(trials.runs)


def test_the_jacobian_is_that_of_differences(kind: Kind[Any], tuna: Robot) -> None:
    trials = samples(kind, tuna)
    nuisances = [kind.nuisance] if kind.nuisance else []
    log = ["water.friction", *(name for name in nuisances if name == "cost_factor")]
    offsets = {recording.name: BETWEEN for recording in trials.recordings}
    told = TOLD.get(kind.key, "water.drag[0,1-6],water.friction")
    frees = free(tuna, [*split_names(told), *nuisances], recordings=offsets, log=log if "friction" in told else [])
    data, values = experiment(tuna, trials, frees, threads=1), [f.start for f in frees]
    exact = predict(data, values, gradient_steps=data.steps).jacobian
    assert exact.shape == (len(data.measured), len(frees))
    for k, one in enumerate(frees):
        step = 1e-5 * max(abs(values[k]), 1.0)
        ends = [predict(data, [*values[:k], values[k] + side * step, *values[k + 1 :]]).computed for side in (-1, 1)]
        slope = (ends[1] - ends[0]) / (2 * step) * (values[k] if one.scale == "log" else 1.0)
        assert np.abs(slope).max() > 0
        assert exact[:, k] == pytest.approx(slope, abs=2e-4 * np.abs(slope).max()), one.name


def test_splitting_loses_no_row(kind: Kind[Any], tuna: Robot) -> None:
    trials = samples(kind, tuna)
    whole = experiment(tuna, trials)
    parts = [part for part in split(trials, 0.4, 1) if part.runs]
    assert len(parts) == 2
    assert sorted(name for part in parts for name in part.runs) == sorted(trials.runs)
    rows = np.concatenate([experiment(tuna, part).measured for part in parts])
    assert np.array_equal(np.sort(rows), np.sort(whole.measured))
    assert {kind_of(trial) for part in parts for trial in part.members} == {kind}
    assert trials.only(()).members == ()


def test_rows_of_several_kinds_stand_one_after_the_other(tuna: Robot) -> None:
    """The rows of all kinds together are those of each alone."""
    all_of = [samples(kind, tuna) for kind in KINDS]
    together = experiment(tuna, sum(reversed(all_of), Trials()))
    alone = [experiment(tuna, trials) for trials in all_of]
    for name in ("measured", "kind", "sd", "known", "count"):
        assert np.array_equal(getattr(together, name), np.concatenate([getattr(one, name) for one in alone])), name
    found = predict(together, []).computed
    assert np.array_equal(found, np.concatenate([predict(one, []).computed for one in alone]))
    names = np.array(together.trials.runs)[together.run]
    assert list(names) == [one.trials.runs[r] for one in alone for r in one.run]


def test_names_and_labels_are_unique() -> None:
    own = [quantity for kind in KINDS for quantity in kind.quantities]
    for names in (
        [kind.key for kind in KINDS],
        [kind.label for kind in KINDS],
        [kind.trial for kind in KINDS],
        [quantity.name for quantity in own],
        [quantity.key for quantity in own],
        [quantity.label for quantity in own],
    ):
        assert len(set(names)) == len(names)


def test_lists_follow_from_the_kinds() -> None:
    own = [quantity for kind in KINDS for quantity in kind.quantities]
    assert list(QUANTITIES) == list(NAMES) == [quantity.name for quantity in own]
    assert list(LABELS) == [quantity.key for quantity in own]
    assert {kind.key for kind in KINDS} < set(Manifest.model_fields)  # a manifest reads every kind


def test_trials_of_a_kind_are_shown(kind: Kind[Any], tuna: Robot) -> None:
    trials = samples(kind, tuna)
    assert f"{kind.label}s" in trials._repr_html_()
    assert "<svg" in trials._repr_html_()
    assert trials.plot().axes
    assert list(trials.to_pandas()["run"]) == list(trials.runs)
    for summary in kind.summaries(trials.members, tuna):
        assert next(kind.lines(summary)).startswith(str(summary.get("name", summary["file"])))


def test_a_manifest_of_one_kind_holds_what_the_whole_one_has_of_it(kind: Kind[Any], tuna: Robot) -> None:
    whole = ht.read_trials([TANK / name for name in MANIFESTS], tuna)
    document: dict[str, Any] = {}
    for name in MANIFESTS:
        document |= tomllib.loads((TANK / name).read_text(encoding="utf-8"))
    others = {one.key for one in KINDS} - {kind.key}
    rest = {key: value for key, value in document.items() if key not in others}
    own = Trials(parse_manifest(rest, tuna, folder=TANK, file="tank.toml"))
    assert own.members
    assert list(own.kinds) == [kind]
    assert digest(own) == digest(Trials(whole.kinds[kind]))
    assert digest(own) != digest(whole)


def test_a_repeated_name_is_refused(kind: Kind[Any], tuna: Robot) -> None:
    trials = samples(kind, tuna)
    with pytest.raises(ht.InputError, match="must be unique"):
        trials + trials
    first = trials.members[0]
    renamed = Trials((*trials.members, replace(first, name="another")))
    assert len(renamed.runs) == len(trials.runs) + len(kind.runs(first))
    assert kind.repeated([first], [replace(first, name=first.name)])


def test_no_module_of_the_fit_asks_for_a_kind() -> None:
    """In the rooms that fit and show trials `.steady` and `.recordings` are read where a task is about these alone."""
    allowed = {
        "cli/replay.py": {"recordings"},  # replays recordings
        "reports/fit.py": {"recordings"},  # the same, as a figure
        "identification/identify.py": {"steady", "recordings"},  # coefficients that belong to trials of a kind
    }
    for room in ("identification", "reports", "cli"):
        for path in (SOURCE / room).rglob("*.py"):
            tree = ast.walk(ast.parse(path.read_text(encoding="utf-8")))
            asked = {
                node.attr
                for node in tree
                if isinstance(node, ast.Attribute)
                and node.attr in {kind.key for kind in KINDS}
                and isinstance(node.value, ast.Name)
                and node.value.id in ("trials", "training", "validation")
            }
            name = path.relative_to(SOURCE).as_posix()
            assert asked <= allowed.get(name, set()), f"{name} asks for {asked}"
