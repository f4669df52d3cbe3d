"""The measured items: one function for each, which returns rows for the tables and the JSON."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from statistics import median

import numpy as np

import hypertuna
import settled
from hypertuna import _core
from peers import fish as fishes
from peers import jax_sweep, mujoco_swim, numba_rhs, scipy_swim
from peers.fish import STEPS, Array
from timing import Race

EVALUATIONS = 4 * STEPS  # evaluations of the right-hand side per beat
BEATS = 40  # beats of each gait in a brute-force sweep
NUMBA_LANES = (1, 4, 8, 16, 32, 64)  # numbers of gaits in step; the fastest one is reported
AGREE = 1e-5  # m/s: a peer whose speed differs by more computes another model
OUR_ERROR = 8e-7  # relative error of our speed with 128 steps per beat; SciPy's tolerance gives the same


@dataclass(frozen=True)
class Row:
    """One measured number."""

    key: str
    what: str
    value: float
    unit: str
    goal: str = ""


@dataclass(frozen=True)
class Item:
    """One table: what it measures and how."""

    title: str
    method: str
    rows: list[Row]


@cache
def setting() -> tuple[hypertuna.Robot, fishes.Fish, fishes.Gaits, hypertuna.Gaits]:
    """Return HyperTuna with ideal joints and the benchmark's grid, in our types and in the peers'."""
    gaits = fishes.grid()
    ours = hypertuna.Gaits(
        gaits.frequency, gaits.amplitude, gaits.phase, bias=np.zeros_like(gaits.phase), shape=(len(gaits),)
    )
    return hypertuna.load("hypertuna").using(joints="ideal"), fishes.load(), gaits, ours


def brute() -> Array:
    """Return the speeds of the grid after `BEATS` beats from rest [m/s]."""
    robot, _, _, gaits = setting()
    return np.asarray(hypertuna.sweep(robot, gaits, method="beats", beats=BEATS, threads=1)["speed"])


def rhs_input(fish: fishes.Fish, gait: fishes.Gaits) -> str:
    """Return the input of benchmarks/rhs.cpp: links, frequency, and eight numbers for each link."""
    groups = fish.share.argmax(axis=1)
    swing = fish.share.max(axis=1) * gait.amplitude[0, groups]
    links = (fish.length, fish.com, fish.inertia, fish.moving_mass, fish.k_t, fish.k_n, swing, gait.phase[0, groups])
    numbers = [fish.links, gait.frequency[0], *np.stack(links, axis=1).ravel()]
    return " ".join(f"{number:.17g}" for number in numbers)


def right_hand_side(executable: Path, turns: int) -> Item:
    """(a) Time the right-hand side, against numba and the processor's peak."""
    fish, gaits = setting()[1:3]
    robot_and_gait = rhs_input(fish, gaits[-1:])
    _check("numba", float(np.abs(numba_rhs.swim(fish, gaits, BEATS) - np.abs(brute())).max()))

    def numba_beat(width: int) -> Callable[[], None]:
        beats = numba_rhs.compile_beats(fish, width)
        state, table, dt = numba_rhs.prepare(fish, gaits[-width:])
        return lambda: beats(state, table, dt, STEPS)

    contestants = {f"{width}": numba_beat(width) for width in NUMBA_LANES}
    runs: list[dict[str, float]] = []
    races = []
    for _ in range(turns):
        run = subprocess.run([executable], input=robot_and_gait, check=True, capture_output=True, text=True)
        runs.append(json.loads(run.stdout))
        races.append(Race(contestants, 5, repeats=10))
    numba = {
        width: median(race.seconds(f"{width}") for race in races) / (EVALUATIONS * width) * 1e9 for width in NUMBA_LANES
    }
    best = min(NUMBA_LANES, key=numba.__getitem__)
    ours = {key: median(run[key] for run in runs) for key in runs[0]}
    widths = {"scalar": "one gait", "w4": "4 lanes", "w8": "8 lanes"}
    fastest = min(ours[f"{width}_ns"] for width in widths)
    rows = [
        *(Row(f"rhs_{width}_ns", f"hypertuna, {text}", ours[f"{width}_ns"], "ns") for width, text in widths.items()),
        Row("rhs_numba_ns", "numba, one gait", numba[1], "ns"),
        Row("rhs_numba_lanes_ns", f"numba, vectorized over {best} gaits", numba[best], "ns"),
        Row("ratio_numba_scalar", "numba over hypertuna, one gait", numba[1] / ours["scalar_ns"], "x"),
        Row("ratio_numba_lanes", "numba over hypertuna, each at its best", numba[best] / fastest, "x"),
        Row("rhs_flops", "+ - * / of a right-hand side", ours["flops_per_rhs"], ""),
        Row(
            "fma_peak_gflops", f"peak of this core ({ours['vector_bits']:.0f} bit)", ours["fma_peak_gflops"], "GFLOP/s"
        ),
        Row("rhs_fraction_of_fma_peak", "hypertuna's share of that peak", ours["fraction"], "", "0.30 or more"),
        *(
            Row(f"rhs_dual_{width}_ns", f"dual numbers, {text}", ours[f"dual_{width}_ns"], "ns")
            for width, text in widths.items()
        ),
        Row("rhs_dual_fraction_of_fma_peak", "their share of that peak", ours["dual_fraction"], ""),
    ]
    method = (
        "The time of one evaluation for one gait, including its part of the Runge-Kutta step. All contestants tabulate "
        "the shape beforehand. The dual numbers carry the derivatives with respect to the three momenta. The same C++ "
        "program measures the peak rate, with independent multiply-adds. It takes turns with numba (`njit`, fastmath)."
    )
    return Item("Right-hand side", method, rows)


def periodic_sweep(turns: int) -> Item:
    """(b) Time the settled beats of a grid of gaits."""
    robot, _, _, gaits = setting()
    race = Race({"sweep": lambda: hypertuna.sweep(robot, gaits, threads=1)}, turns)
    beats = float(hypertuna.sweep(robot, gaits, threads=1)["beats"].mean())
    goal = "15 or less" if _core.lanes() == 8 else "25 or less"
    rows = [
        Row("sweep_180_periodic_ms", "180 settled gaits", 1e3 * race.seconds("sweep"), "ms", goal),
        Row("sweep_180_beats", "beats integrated for a gait, mean", beats, ""),
    ]
    method = (
        "`hypertuna.sweep` of 6 frequencies (1 to 6 Hz), 10 phases (0 to 180 deg) and 3 amplitude levels on one "
        f"thread, with {STEPS} steps per beat, including the Dataset. Median of {turns}."
    )
    return Item("Periodic sweep", method, rows)


def against_jax(turns: int) -> Item:
    """(c) Time the sweep of that grid by brute force, against JAX."""
    _, fish, gaits, _ = setting()
    sweeps, compile_seconds = {}, {}
    for program in jax_sweep.PROGRAMS:
        clock = time.perf_counter()
        sweeps[program] = jax_sweep.compile_sweep(program, fish, gaits, BEATS)
        compile_seconds[program] = time.perf_counter() - clock
    reference = np.abs(brute())
    for program, sweep in sweeps.items():
        _check(f"JAX ({program})", float(np.abs(sweep() - reference).max()))
    race = Race({"hypertuna": brute, **sweeps}, turns)
    rows = [Row("brute_ms", f"hypertuna, {BEATS} beats", 1e3 * race.seconds("hypertuna"), "ms")]
    for program in sweeps:
        label = f"JAX `{program}`"
        rows += [
            Row(f"jax_{program}_ms", f"{label}, {BEATS} beats", 1e3 * race.seconds(program), "ms"),
            Row(f"jax_{program}_compile_s", f"{label}, compilation (not counted)", compile_seconds[program], "s"),
            Row(f"ratio_jax_{program}", f"{label} over hypertuna", race.ratio(program, "hypertuna"), "x"),
        ]
    ratio = race.ratio("direct", "hypertuna")
    rows.append(Row("ratio_jax_brute", "JAX as one writes it (`direct`) over hypertuna", ratio, "x", "40 or more"))
    method = (
        f"The grid above. Every gait swims {BEATS} beats from rest with {STEPS} Runge-Kutta steps each, and the last "
        "beat is measured (JAX: speed; hypertuna: speed, power, cost of transport, excursion, radius). JAX runs with "
        "jit, x64, on one core of the CPU. `direct` is a straightforward program: the paper's equations under vmap, "
        "solved for the acceleration. The goal of 40 x refers to it. `tabled` copies our form (momentum, tabulated "
        "shape) under vmap. `fused` is that form rearranged by hand, after reading the code that XLA makes of it. It "
        "is nearly as fast as hypertuna, so most of the 40 x come from the form of the equations and not from the "
        f"language. Median of {turns} turns."
    )
    return Item("Brute force against JAX", method, rows)


def against_scipy_and_mujoco(turns: int) -> Item:
    """(d) Time one gait in SciPy and in MuJoCo."""
    robot, fish, gaits, _ = setting()
    k = int(np.argmax(gaits.frequency * gaits.amplitude.sum(axis=1) - gaits.phase[:, 1]))  # 6 Hz, large, phase 0
    gait, beats = gaits[k : k + 1], 5
    ours = hypertuna.Gait(float(gait.frequency[0]), tuple(map(float, gait.amplitude[0])), (0.0, 0.0))
    settled = hypertuna.sweep(robot, [ours], method="beats", beats=BEATS, threads=1)["speed"].item()
    swimmer = mujoco_swim.Swimmer(fish, gait)
    _check("MuJoCo", abs(mujoco_swim.swim(swimmer, BEATS) - settled), 0.01 * settled)
    contestants: dict[str, Callable[[], object]] = {
        "one": lambda: hypertuna.sweep(robot, [ours], method="beats", beats=10 * BEATS, threads=1),
        "grid": brute,
        "MuJoCo": lambda: mujoco_swim.swim(swimmer, beats),
    }
    gait_beats = {"one": 10 * BEATS, "grid": BEATS * len(gaits), "MuJoCo": beats}
    labels = {"MuJoCo": "MuJoCo"}
    for method in scipy_swim.METHODS:
        rtol = scipy_swim.matched_rtol(fish, gait, beats, method=method, error=OUR_ERROR)

        def swim(method: str = method, rtol: float = rtol, beats: int = beats) -> float:
            return scipy_swim.swim(fish, gait, beats, method=method, rtol=rtol)

        _check(method, abs(swim(beats=BEATS) - settled), 1e-5 * settled)
        contestants[method], gait_beats[method] = swim, beats
        labels[method] = f"SciPy {method}, rtol {rtol:.0e}"
    race = Race(contestants, turns)
    milli = {name: 1e3 * race.seconds(name) / gait_beats[name] for name in contestants}
    rows = [
        Row("beat_grid_ms", "hypertuna, in the grid", milli["grid"], "ms"),
        Row("beat_one_ms", "hypertuna, alone", milli["one"], "ms"),
    ]
    for name, label in labels.items():
        key, share = name.lower(), gait_beats["grid"] / gait_beats[name]
        rows += [
            Row(f"beat_{key}_ms", label, milli[name], "ms"),
            Row(f"ratio_{key}", f"{name} over hypertuna in the grid", race.ratio(name, "grid") * share, "x"),
        ]
    method = (
        "The time of one beat of one gait (6 Hz, 16 and 25 deg, phase 0). SciPy uses `solve_ivp` with a NumPy "
        f"right-hand side in complex numbers, at the loosest tolerance whose speed is right to {OUR_ERROR:g}. MuJoCo "
        f"has the same chain with driven joints, {STEPS} steps per beat of its own integrator (first order, 1 % off in "
        f"speed), and drag by numba. hypertuna takes {STEPS} Runge-Kutta steps per beat, through the Python API. "
        f"Median of {turns} turns."
    )
    return Item("SciPy and MuJoCo", method, rows)


def many_gaits(counts: tuple[int, ...]) -> Item:
    """(e) Measure time and memory of large sweeps."""
    runs = []
    for count in counts:
        command = [sys.executable, str(Path(__file__).with_name("many.py")), str(count)]
        runs.append(json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout))
    rows: list[Row] = []
    for run in runs:
        name, goal = f"{run['gaits']:.0e}".replace("e+0", "e"), "2 or less" if run["gaits"] == 10**6 else ""
        rows += [
            Row(f"sweep_{name}_s", f"{run['gaits']:,} gaits", run["seconds"], "s"),
            Row(f"sweep_{name}_us_per_gait", "time of a gait", 1e6 * run["seconds"] / run["gaits"], "us"),
            Row(f"sweep_{name}_peak_gb", "peak memory of the process", run["peak_bytes"] / 1e9, "GB", goal),
            Row(f"sweep_{name}_settled", "settled", 100 * run["settled"], "%"),
        ]
    per_gait = [run["seconds"] / run["gaits"] for run in runs]
    growth = per_gait[-1] / per_gait[0]
    rows.append(Row("sweep_linearity", "time of a gait, largest sweep over smallest", growth, "x", "1"))
    method = "`hypertuna.sweep` of random gaits within the paper's bounds, on one thread, each in its own process."
    return Item("Large sweeps", method, rows)


def call_overhead(turns: int) -> Item:
    """(f) Time a call of `swim`, without the time in the core."""
    robot = setting()[0]
    gait = hypertuna.Gait.from_degrees(frequency=6, amplitude=(16, 25), phase=(0, 40))
    core, inside = _core.settle, []

    def timed(*arguments: object, **options: object) -> object:
        start = time.process_time()
        result = core(*arguments, **options)
        inside.append(time.process_time() - start)
        return result

    def overheads() -> Iterator[tuple[float, float]]:
        for _ in range(turns):
            inside.clear()
            start = time.process_time()
            hypertuna.swim(robot, gait)
            yield time.process_time() - start - sum(inside), sum(inside)

    hypertuna.swim(robot, gait)
    _core.settle = timed
    try:
        beyond, within = (median(column) for column in zip(*overheads(), strict=True))
    finally:
        _core.settle = core
    rows = [
        Row("swim_overhead_ms", "`hypertuna.swim` beyond the core", 1e3 * beyond, "ms", "0.2 or less"),
        Row("swim_core_ms", "the core's part of it", 1e3 * within, "ms"),
    ]
    return Item("One call", f"The time of the whole call minus that of the core inside it. Median of {turns}.", rows)


def settled_gaits(turns: int) -> Item:
    """(k) Time settled gaits under the water laws that leave a wake."""
    contestants = settled.cases()
    race = Race({name: run for name, (run, _) in contestants.items()}, turns)
    rows = []
    for name, (run, count) in contestants.items():
        key = "settled_" + "_".join(re.findall(r"\w+", name.lower()))
        rows += [
            Row(f"{key}_us", name, 1e6 * race.seconds(name) / count, "us"),
            Row(f"{key}_beats", "its beats, mean", run(), ""),
        ]
    method = (
        "The core's time of a settled gait of the grid above, in lanes or one by one, with ideal joints and one "
        "thread. `robot new` is its fish of three links. `python benchmarks/settled.py OLD NEW` compares two builds by "
        f"these cases. Median of {turns}."
    )
    return Item("Settled gaits on strips and elongated water", method, rows)


def twin_speed(turns: int) -> Item:
    """(i) Time the twin, relative to real time."""
    robot, duration = hypertuna.load("hypertuna"), 20.0
    gait = hypertuna.Gait.from_degrees(frequency=3, amplitude=(12, 20), phase=(0, 20))
    race = Race({"twin": lambda: hypertuna.twin(robot, gait, duration=duration)}, turns)
    seconds = race.seconds("twin")
    rows = [
        Row("twin_real_time", "the twin over real time", duration / seconds, "x", "100 or more"),
        Row("twin_run_ms", f"a run of {duration:g} s", 1e3 * seconds, "ms"),
    ]
    method = (
        "`hypertuna.twin` in closed loop, at 3 Hz, 12 and 20 deg, in water, on one thread, without the time for the "
        f"robot's tables. Median of {turns}."
    )
    return Item("Twin", method, rows)


def many_twins(turns: int) -> Item:
    """(j) Time twins side by side in lanes, and environments for learning, with each instruction set installed."""
    runs = []
    for isa in _core.isas():
        command = [sys.executable, str(Path(__file__).with_name("twins.py")), str(turns)]
        where = os.environ | {"HYPERTUNA_ISA": isa}
        runs.append(json.loads(subprocess.run(command, env=where, check=True, capture_output=True, text=True).stdout))
    rows = [Row("twins_alone", "runs of 20 s, `hypertuna.twin`", runs[0]["alone"], "1/s")]
    for run in runs:
        name, lanes = run["isa"], run["lanes"]
        rows += [
            Row(f"twins_{name}", f"{name}, lanes: {lanes}: runs of 20 s", run["together"], "1/s"),
            Row(f"twins_{name}_gain", "over `hypertuna.twin`", run["gain"], "x"),
            Row(f"environment_{name}", "steps of 0.1 s of `hypertuna/Goto-v0`", run["steps"], "1/s", "5,000"),
        ]
    method = (
        "`hypertuna.twins` swims `unoptimised-max` from rest, including the records. The vector environment has 128 "
        "swimmers under random actions. Both run on one thread, with each instruction set in its own process. "
        f"Median of {turns}."
    )
    return Item("Many twins", method, rows)


def _check(who: str, difference: float, most: float = AGREE) -> None:
    """End the program if a peer's speed differs by more than `most` [m/s]: the peer computes another model."""
    if not difference <= most:
        raise SystemExit(f"{who} computes another speed: it differs by {difference:.2e} m/s, more than {most:.0e}")
