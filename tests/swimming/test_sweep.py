"""Many gaits at once: labels, and the whole box of gaits of the paper."""

from __future__ import annotations

import signal
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from matplotlib.text import Text

import hypertuna as ht
from hypertuna import _core
from hypertuna.io.files import write_netcdf
from hypertuna.swimming.beat import DEFAULT_STEPS, QUANTITIES, STATUSES
from hypertuna.swimming.gait import Gaits
from hypertuna.swimming.model import core_model
from hypertuna.swimming.sweep import CHUNK
from models import MODELS, changed, fastest

FREQUENCY = [1.0, 2.5, 6.0]
AMPLITUDE = np.deg2rad([(8.0, 12.0), (16.0, 25.0)]).tolist()
PHASE = np.deg2rad([(0.0, 0.0), (0.0, 20.0), (0.0, 40.0), (0.0, 60.0)]).tolist()
BIAS = np.deg2rad([(0.0, 0.0), (3.0, 5.0)]).tolist()


def grid() -> Gaits:
    return Gaits.grid(frequency=FREQUENCY, amplitude=AMPLITUDE, phase=PHASE, bias=BIAS)


# --- labels


def test_a_grid_is_every_combination_in_order(tuna: ht.Robot) -> None:
    found = ht.sweep(tuna, grid())
    assert found.speed.dims == ("frequency", "amplitude", "phase", "bias")
    assert found.speed.shape == (3, 2, 4, 2)
    np.testing.assert_array_equal(found.frequency, FREQUENCY)
    for name, axis in {"amplitude": AMPLITUDE, "phase": PHASE, "bias": BIAS}.items():
        for g, group in enumerate(("I", "II")):
            coordinate = found[f"{name}_{group}"]
            assert coordinate.dims == (name,)
            assert coordinate.attrs["units"] == "rad"
            np.testing.assert_array_equal(coordinate, np.array(axis)[:, g])
    for place in [(0, 0, 0, 0), (2, 1, 3, 1), (1, 0, 2, 1), (2, 0, 1, 0)]:
        f, a, p, b = place
        swim = ht.swim(tuna, ht.Gait(FREQUENCY[f], AMPLITUDE[a], PHASE[p], BIAS[b]))
        for name in QUANTITIES:
            assert float(found[name][place]) == float(getattr(swim, name)), name
        assert STATUSES[int(found.status[place])] == swim.status


def test_a_list_keeps_its_order(tuna: ht.Robot) -> None:
    gaits = [ht.Gait(f, AMPLITUDE[1], PHASE[2], BIAS[k % 2]) for k, f in enumerate((3.0, 1.0, 2.0))]
    found = ht.sweep(tuna, gaits)
    assert found.speed.dims == ("gait",)
    np.testing.assert_array_equal(found.frequency, [3.0, 1.0, 2.0])
    np.testing.assert_array_equal(found.bias_II, [gait.bias[1] for gait in gaits])
    for k, gait in enumerate(gaits):
        assert float(found.speed[k]) == ht.swim(tuna, gait).speed


def test_every_variable_has_a_unit_and_a_meaning(tuna: ht.Robot) -> None:
    found = ht.sweep(tuna, grid())
    assert set(found.data_vars) == {*QUANTITIES, "status", "settled"}
    for name in QUANTITIES:
        assert found[name].attrs == {"units": QUANTITIES[name].unit, "long_name": QUANTITIES[name].meaning}
    assert found.status.attrs["flag_meanings"].split() == list(STATUSES)
    assert found.settled.dtype == bool
    assert (found.attrs["robot"], found.attrs["method"], found.attrs["steps"]) == (tuna.name, "newton", 128)


def test_netcdf_round_trip(tuna: ht.Robot, tmp_path: Path) -> None:
    swept = ht.sweep(tuna, grid())
    with xr.open_dataset(write_netcdf(swept, tmp_path / "sweep.nc"), engine="h5netcdf") as found:
        xr.testing.assert_equal(found.load(), swept)
        assert found.speed.attrs == swept.speed.attrs
        assert found.attrs["robot_hash"] == tuna.hash


def test_ctrl_c_ends_a_sweep_within_a_thousand_gaits(tuna: ht.Robot) -> None:
    seen: list[int] = []

    def interrupt(done: int, whole: int) -> None:
        seen.append(done)
        signal.raise_signal(signal.SIGINT)

    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell may have its jobs ignore it
    try:
        with pytest.raises(KeyboardInterrupt):
            ht.sweep(tuna, [fastest(tuna)] * 3000, method="beats", beats=1, steps=8, progress=interrupt)
    finally:
        signal.signal(signal.SIGINT, before)
    assert seen[0] <= 1024
    assert len(seen) == 1


def test_progress_is_reported_to_the_end(tuna: ht.Robot) -> None:
    seen: list[tuple[int, int]] = []
    gaits = [fastest(tuna)] * (CHUNK + 1)
    ht.sweep(tuna, gaits, method="beats", beats=1, steps=8, progress=lambda done, whole: seen.append((done, whole)))
    assert seen == [(CHUNK, CHUNK + 1), (CHUNK + 1, CHUNK + 1)]


def test_beats_are_those_of_a_swim_from_rest(tuna: ht.Robot) -> None:
    gait = fastest(tuna)
    found = ht.sweep(tuna, [gait], method="beats", beats=7)
    swim = ht.swim(tuna, gait, from_rest=7 / gait.frequency)
    for name in ("speed", "mechanical_power", "tail_excursion"):
        assert float(found[name][0]) == getattr(swim, name)


def test_a_gait_that_diverges_leaves_the_others_untouched() -> None:
    """Lanes next to it, too."""
    robot = MODELS["hypertuna-lumped"]
    stiff = changed(robot, {"water.lumped.drag": [1e4] * len(robot.links.name)})
    calm, wild = ht.Gait(1.0, (1e-4, 1e-4), (0.0, 0.5)), fastest(robot)
    mixed = ht.sweep(stiff, [calm, wild, calm, wild, wild, calm], steps=8)
    assert [STATUSES[k] for k in mixed.status.values] == [
        "settled",
        "diverged",
        "settled",
        "diverged",
        "diverged",
        "settled",
    ]
    alone = ht.swim(stiff, calm, steps=8)
    np.testing.assert_array_equal(mixed.speed[[0, 2, 5]], alone.speed)


# --- the paper's box


def box(count: int, seed: int) -> Gaits:
    """Gaits drawn evenly from the paper's box: up to 16 and 25 deg, 0.1 to 6 Hz, lags of 0 to 80 deg."""
    rng = np.random.default_rng(seed)
    amplitude = np.deg2rad(rng.uniform(0, (16, 25), (count, 2)))
    phase = np.deg2rad(rng.uniform(0, (0, 80), (count, 2)))
    return Gaits(rng.uniform(0.1, 6.0, count), amplitude, phase, np.zeros((count, 2)), shape=(count,))


def some(gaits: Gaits, index: np.ndarray) -> Gaits:
    columns = (getattr(gaits, name)[index] for name in ("frequency", "amplitude", "phase", "bias"))
    return Gaits(*columns, shape=(len(index),))


@cache
def swept_box(name: str) -> tuple[ht.Robot, Gaits, xr.Dataset]:
    """A model, ten thousand gaits and how it swims them."""
    robot, gaits = MODELS[name], box(10_000, seed=2)
    return robot, gaits, ht.sweep(robot, gaits)


@pytest.mark.parametrize("name", ["hypertuna-lumped", "hypertuna-lumped-ideal", "hypertuna-strip"])
def test_every_gait_of_the_box_settles_and_none_is_silently_wrong(name: str) -> None:
    robot, gaits, found = swept_box(name)
    assert (found.distance_to_settled < _core.SETTLED_DISTANCE).where(found.settled, True).all()
    unsettled = np.flatnonzero(~found.settled)
    assert len(unsettled) == 0, f"gaits {unsettled} did not settle"

    # 2000 beats settle where a beat leaves no more than 0.99 of a disturbance: 0.99^2000 = 2e-9.
    brisk = np.flatnonzero(found.spectral_radius < 0.99)
    assert len(brisk) > len(gaits) / 2
    sample = np.random.default_rng(2).choice(brisk, 40, replace=False)
    waited = ht.sweep(robot, some(gaits, sample), method="beats", beats=2000)
    assert waited.settled.all()
    for quantity in ("speed", "mechanical_power"):
        np.testing.assert_allclose(found[quantity][sample], waited[quantity], rtol=1e-5)


def beat_map(robot: ht.Robot, gait: ht.Gait) -> Callable[[np.ndarray], tuple[np.ndarray, float]]:
    """Return the map of a twist to the one a beat later and the mean speed over the beat."""
    model, steps = core_model(robot), DEFAULT_STEPS
    angles = {name: getattr(gait, name) for name in ("frequency", "amplitude", "phase", "bias")}
    joints = _core.joint_motion(model, **angles, clock=np.linspace(0, 2 * np.pi, 2 * steps + 1))

    def beat(twist: np.ndarray) -> tuple[np.ndarray, float]:
        motion = _core.advance(model, joints, step=1 / gait.frequency / steps, twist=twist, pose=np.zeros(3))
        return motion["twist"][-1], float(np.hypot(*motion["pose"][-1, :2]) * gait.frequency)

    return beat


@pytest.mark.parametrize("name", ["hypertuna-lumped", "hypertuna-strip"])
def test_gaits_too_slow_to_wait_for_are_right_too(name: str) -> None:
    """Gaits that hardly move take thousands of beats to settle: two more steps of Newton's method change nothing."""
    robot, gaits, found = swept_box(name)
    errors = {}
    for k in np.argsort(-found.spectral_radius.values)[:20].tolist():
        gait = ht.Gait(gaits.frequency[k], gaits.amplitude[k], gaits.phase[k])
        swim = ht.swim(robot, gait)
        twist = np.array([float(swim.trajectory[v][0]) for v in ("u", "v", "r")])
        beat, h = beat_map(robot, gait), 1e-5 * abs(twist).max()
        ends = [beat(twist + h * e)[0] - beat(twist - h * e)[0] for e in np.eye(3)]
        monodromy = np.stack(ends, axis=1) / (2 * h)
        for _ in range(2):
            twist = twist + np.linalg.solve(np.eye(3) - monodromy, beat(twist)[0] - twist)
        if swim.settled:
            errors[k] = abs(swim.speed) / beat(twist)[1] - 1
    assert errors
    worst = max(errors, key=lambda k: abs(errors[k]))
    assert abs(errors[worst]) < 1e-3, f"gait {worst} is settled, but its speed is {errors[worst]:.1%} off"


# --- bad input


def test_bad_input_is_told_in_a_sentence(tuna: ht.Robot) -> None:
    with pytest.raises(
        ht.InputError, match="^gaits must hold at least one gait, but is empty: give the gaits to swim.$"
    ):
        ht.sweep(tuna, [])
    unlike = [ht.Gait(1.0, (0.1,), (0.0,)), ht.Gait(1.0, (0.1, 0.1), (0.0, 0.0))]
    with pytest.raises(
        ht.InputError, match="^gaits must have equally many joint groups: give every gait one value per "
    ):
        Gaits.of(unlike)
    with pytest.raises(ht.InputError, match="^amplitude must be 2 long, one value per joint group of hypertuna"):
        ht.sweep(tuna, unlike[:1])
    with pytest.raises(ht.InputError, match="^beats must be at least 1, but is 0: give the beats to swim from rest.$"):
        ht.sweep(tuna, [fastest(tuna)], method="beats", beats=0)
    with pytest.raises(ht.InputError, match="^method must be newton or beats, but is 'newtons'"):
        ht.sweep(tuna, [fastest(tuna)], method="newtons")  # type: ignore[arg-type]
    with pytest.raises(ht.InputError, match="^steps must be a multiple of 4"):
        ht.sweep(tuna, [fastest(tuna)], steps=127)


@pytest.mark.parametrize(
    ("axes", "sentence"),
    [
        ({"frequency": []}, "frequency must have at least one value, but is empty: give a range or a list."),
        ({"frequency": [1.0, 0.0]}, "frequency must be greater than 0, but is 0: give it in Hz."),
        ({"amplitude": []}, "amplitude must have at least one value, but is empty: give a range or a list."),
        (
            {"amplitude": [(0.1, 0.1), (0.1, -0.1)]},
            "amplitude[1] must not be negative, but is -0.1: add half a turn to its phase instead.",
        ),
        (
            {"phase": [(0.0, 0.0), (0.0,)]},
            "phase[1] must be 2 long, as phase[0] is, but is 1 long: give one angle per joint group.",
        ),
        (
            {"bias": [(0.0, float("nan"))]},
            "bias[1] must be a finite number, but is nan: give one angle per joint group.",
        ),
    ],
)
def test_bad_grids_are_told_in_a_sentence(axes: dict[str, object], sentence: str) -> None:
    good = {"frequency": FREQUENCY, "amplitude": AMPLITUDE, "phase": PHASE}
    with pytest.raises(ht.InputError) as error:
        Gaits.grid(**(good | axes))  # type: ignore[arg-type]
    assert str(error.value) == sentence


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"frequency": np.array([1.0, 0.0])}, "frequency must be greater than 0, but is 0: give it in Hz."),
        ({"phase": np.array([[0.0, 1.0], [np.nan, 1.0]])}, "phase[0] must be a finite number, but is nan"),
        ({"amplitude": np.array([[0.1, 16.0], [0.1, 0.1]])}, "amplitude[1] must be at most 3.14159 rad, but is 16"),
        ({"bias": np.zeros((2, 3))}, "bias must have the shape (2, 2), one row per gait, but is (2, 3)"),
        ({"shape": (3,)}, "shape must multiply to 2, the number of gaits, but is (3,)"),
        ({"shape": (2, 2, 2, 1)}, "shape must be (2, 2, 2, 2), but is (2, 2, 2, 1): use Gaits.grid."),
    ],
)
def test_gaits_made_by_hand_are_checked_too(changes: dict[str, object], sentence: str) -> None:
    good = {"frequency": np.ones(2), "phase": np.zeros((2, 2)), "amplitude": np.full((2, 2), 0.1)}
    good |= {"bias": np.zeros((2, 2)), "shape": (2,)}
    Gaits(**good)
    with pytest.raises(ht.InputError) as raised:
        Gaits(**good | changes)
    assert str(raised.value).startswith(sentence)


def test_a_grid_too_large_for_the_memory_is_refused_before_it_is_made() -> None:
    axis = np.linspace(0, 1, 10_000)
    vast = Gaits.grid(frequency=1 + axis, amplitude=[(a, a) for a in axis], phase=[(0.0, 0.0)])
    assert vast[10_001] == ht.Gait(1 + axis[1], (axis[1], axis[1]), (0.0, 0.0))
    for whole in (lambda: ht.sweep("hypertuna", vast), lambda: vast.columns):
        with pytest.raises(ht.InputError, match="^the number of gaits must be at most 10000000, but is 100000000"):
            whole()


def test_threads_are_at_least_one(tuna: ht.Robot) -> None:
    with pytest.raises(ht.InputError, match="^threads must be at least 1, but is -3"):
        ht.sweep(tuna, [fastest(tuna)], threads=-3)


def test_a_grid_is_found_by_its_values() -> None:
    fish = ht.load("hypertuna")
    lags = [(0, lag) for lag in range(0, 91, 30)]
    gaits = Gaits.grid_degrees(frequency=[1, 2], amplitude=[(8, 15), (16, 25)], phase=lags)
    assert gaits[5] == ht.Gait.from_degrees(frequency=1, amplitude=(16, 25), phase=(0, 30))
    grid = ht.sweep(fish, gaits)
    near = grid.sel(phase=40, frequency=1.9, method="nearest")  # degrees, as the grid was given
    assert (near.phase_II.item(), near.phase_II.attrs["units"]) == (30, "deg")
    assert near.frequency == 2
    assert grid.phase.attrs["long_name"] == "phase of joint group II"
    radians = ht.sweep(fish, replace(gaits, degrees=False))
    assert radians.phase.attrs["units"] == "rad"
    assert radians.sel(phase=np.radians(40), method="nearest").phase_II == np.radians(30)
    pd.testing.assert_frame_equal(ht.to_pandas(radians), ht.to_pandas(grid))
    plots = (ht.plot_sweep(one) for one in (radians, grid))
    assert len({str([text.get_text() for text in plot.findobj(Text)]) for plot in plots}) == 1
    # Amplitudes that the last group shares are found by the first; where none differs, there is no index.
    same = Gaits.grid_degrees(frequency=[1], amplitude=[(8, 20), (9, 20)], phase=[(0, 0), (0, 0)])
    other = ht.sweep(fish, same)
    assert other.amplitude.values == pytest.approx([8, 9])
    assert "phase" not in other.coords


def test_a_grid_is_a_table_with_units_in_the_names_of_columns() -> None:
    grid = ht.sweep("hypertuna", Gaits.grid_degrees(frequency=[1, 2], amplitude=[(8, 15)], phase=[(0, 0), (0, 40)]))
    table = ht.to_pandas(grid)
    assert list(table.columns[:5]) == [
        "frequency_hz",
        "amplitude_I_deg",
        "amplitude_II_deg",
        "phase_I_deg",
        "phase_II_deg",
    ]
    assert {"speed_m_s", "cost_of_transport_j_per_kg_m", "status"} <= set(table.columns)
    assert table.phase_II_deg.tolist() == [0, 40, 0, 40]
    assert table.attrs["robot"] == "hypertuna"


def test_a_grid_in_degrees_names_the_bad_angle_in_degrees() -> None:
    with pytest.raises(ht.InputError, match=r"amplitude\[1\] must be at most 180 deg, but is 250"):
        Gaits.grid_degrees(frequency=[1], amplitude=[(8, 15), (8, 250)], phase=[(0, 0)])
    with pytest.raises(ht.InputError, match=r"phase must be a list.*write phase=\["):
        Gaits.grid(frequency=[1], amplitude=[(0.1, 0.2)], phase=3)  # type: ignore[arg-type]


def test_a_sweep_resumes_to_the_same_bytes(tmp_path: Path, tuna: ht.Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("hypertuna.swimming.sweep.CHUNK", 2)
    gaits = Gaits.grid_degrees(frequency=[1, 2, 3, 4, 5], amplitude=[(8, 12)], phase=[(0, 40)])
    whole = ht.sweep(tuna, gaits, check_rest=True)
    journal = tmp_path / "sweep.journal"

    def stop(done: int, _: int) -> None:
        if done == 4:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        ht.sweep(tuna, gaits, check_rest=True, checkpoint=journal, progress=stop)
    kept = journal.read_bytes()
    assert kept.count(b"\n") == 3  # the header, and two chunks
    resumed = ht.sweep(tuna, gaits, check_rest=True, checkpoint=journal)
    assert resumed.identical(whole)
    assert all(resumed[name].dtype == whole[name].dtype for name in whole)
    assert journal.read_bytes().startswith(kept)
    with pytest.raises(ht.InputError, match="steps"):
        ht.sweep(tuna, gaits, check_rest=True, checkpoint=journal, steps=64)

    lines = journal.read_bytes().split(b"\n")
    lines[2] = lines[2].replace(b"1", b"2", 1)
    journal.write_bytes(b"\n".join(lines))
    with pytest.warns(match="damaged"):
        assert ht.sweep(tuna, gaits, check_rest=True, checkpoint=journal).identical(whole)
