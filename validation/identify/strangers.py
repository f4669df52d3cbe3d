"""Robots that are not ours, known from their shape and tracked markers: are swims predicted that the fit has not seen?

    python validation/identify/strangers.py [-o strangers.json]       # about 20 minutes; resumes after an interruption

A stranger is a chain of ellipses, described by lengths, heights and widths; its coefficients are those of a handbook.
Its swims follow other coefficients, or another law, and are seen as markers with noise on every link, 60 frames a
second. `hypertuna trials import markers` and `hypertuna identify` with default options see three of
the swims, and predict two.
Coverage: the same robot with other noise, over and over; do 90 % intervals hold the coefficients that made the swims?
"""

from __future__ import annotations

import argparse
import json
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy.special import stdtrit

import hypertuna as ht
from hypertuna.description.robot import parse
from hypertuna.identification.coefficients import from_scale, to_scale
from hypertuna.identification.identify import identify
from hypertuna.io.files import version
from hypertuna.swimming.beat import settle
from hypertuna.trials.chain import chain_of
from hypertuna.trials.marker_import import read_marker_run, write_marker_runs
from hypertuna.trials.marker_places import equal_spacing
from hypertuna.trials.trials import Trials, read_trials

NOISE, RATE, BEATS = 0.0015, 60.0, 4  # noise of a marker's coordinate [m]; frames per second; beats of a run
TRAINED, HELD = (0, 2, 3), (1, 4)  # runs of each robot that are fitted, and that are predicted
WAVE, TAPER = 0.8, (0.6, 1.2)  # waves on the body; amplitude of the first and the last joint over the mean one
COVERED = range(1000, 1020)  # seeds of the coverage; others were used during development
WITHOUT = range(1000, 1006)  # seeds of fits without priors

# lengths, heights, widths of the links [m]; runs: frequency [Hz] and amplitude [deg]
SHAPES: dict[str, tuple[Any, Any, Any, list[tuple[float, float]]]] = {
    "eel of 6 links, 0.6 m": (
        np.full(6, 0.1),
        np.full(6, 0.09),
        np.full(6, 0.025),
        [(0.5, 15), (0.5, 30), (0.8, 20), (0.8, 30), (1.0, 25)],
    ),
    "eel of 9 links, 0.25 m": (
        np.full(9, 0.028),
        np.linspace(0.03, 0.02, 9),
        np.linspace(0.025, 0.012, 9),
        [(1.0, 15), (1.5, 25), (2.0, 20), (3.0, 15), (2.5, 25)],
    ),
    "fish of 5 links, 0.4 m": (
        np.array([0.16, 0.07, 0.06, 0.05, 0.05]),
        np.array([0.10, 0.10, 0.06, 0.035, 0.10]),
        np.array([0.06, 0.05, 0.03, 0.015, 0.006]),
        [(1.0, 12), (2.0, 12), (3.0, 12), (2.0, 20), (3.5, 16)],
    ),
    "eel of 11 links, 1 m": (
        np.full(11, 0.091),
        np.full(11, 0.07),
        np.full(11, 0.06),
        [(0.3, 15), (0.3, 25), (0.5, 20), (0.7, 20), (0.7, 28)],
    ),
}


def handbook(links: int, **more: Any) -> dict[str, Any]:
    """Return a strip law by potential flow, plates across the flow and turbulent boundary layers, changed by `more`."""
    table = {
        "added_mass_normal": [1.0] * links,
        "added_mass_tangential": [0.0] * links,
        "added_inertia": [1.0] * links,
        "drag_normal": [2.0] * links,
        "drag_tangential": [0.01] * links,
    }
    return table | more


LAWS: dict[str, Any] = {  # true strip law of `n` links, by name
    "same law": lambda n: handbook(n, added_mass_normal=[1.4] * n, drag_normal=[1.4] * n, drag_tangential=[0.04] * n),
    "sheds at its tail": lambda n: handbook(
        n,
        added_mass_normal=[1.3] * (n - 1) + [0.8],
        drag_normal=[1.6] * n,
        drag_tangential=[0.05] * n,
        tail_shedding=1.0,
    ),
    "elongated body": lambda n: {
        "added_mass_normal": [1.0] * n,
        "added_mass_edge": 1.0,
        "drag_normal": [1.5] * n,
        "drag_tangential": [0.04] * n,
    },
}


def described(shape: str, water: dict[str, Any], law: str = "strip") -> ht.Robot:
    """Return a robot with elliptical links, as dense as water."""
    length, height, width, _ = SHAPES[shape]
    a, b = height / 2, width / 2
    girth = np.pi * (3 * (a + b) - np.sqrt((3 * a + b) * (a + 3 * b)))  # Ramanujan
    mass = 1000 * np.pi * a * b * length
    links = {"length_m": length, "com_m": length / 2, "mass_kg": mass}
    links |= {"lateral_area_m2": height * length, "wetted_area_m2": girth * length}
    names = [f"L{k}" for k in range(len(length))]
    return parse(
        {
            "format": 1,
            "name": "stranger",
            "description": shape,
            "body": {"length_m": float(length.sum()), "mass_kg": float(mass.sum())},
            "links": {"name": names} | {key: values.tolist() for key, values in links.items()},
            "joints": [{"name": f"{k}", "links": [k]} for k in range(1, len(length))],
            "model": {"water": law},
            "water": {"density_kg_m3": 1000.0, law: water},
        },
        file=shape,
    )


def truth_of(shape: str, law: str) -> ht.Robot:
    """Return the robot that swims, with true coefficients."""
    water = LAWS[law](len(SHAPES[shape][0]))
    return described(shape, water, "elongated" if law == "elongated body" else "strip")


def gait_of(robot: ht.Robot, frequency: float, amplitude: float) -> ht.Gait:
    """Return the gait of a run: a wave along the body."""
    groups = len(robot.joints)
    phase = 360 * WAVE / groups * np.arange(groups)
    size = amplitude * np.linspace(*TAPER, groups)
    return ht.Gait.from_degrees(frequency=frequency, amplitude=size.tolist(), phase=phase.tolist())


def tracked(truth: ht.Robot, gait: ht.Gait, begin: str, random: Any, file: Path) -> None:
    """Write the markers of a run that a camera sees: from rest, or after four beats."""
    f, count = gait.frequency, 2 * len(truth.links.name) + 1
    lead = 0.0 if begin == "rest" else 4 / f
    time = np.arange(0, lead + BEATS / f + 1e-9, 1 / (240 * max(f, 1.0)))
    ramp = np.clip(time * f, 0, 1)
    wave = np.sin(2 * np.pi * f * time[:, np.newaxis] - np.array(gait.phase)) * np.array(gait.amplitude)
    series = ht.JointSeries(time, (ramp**2 * (3 - 2 * ramp))[:, np.newaxis] * wave)
    swim = ht.replay(truth, ht.smooth(series, noise=0.0), start=ht.Pose(0.9, 0.4, 0.3))
    seen = np.arange(lead, lead + BEATS / f, 1 / RATE)
    pose = [np.interp(seen, swim.time, swim[axis]) for axis in ("x", "y", "heading")]
    angle = [np.interp(seen, time, column) for column in series.angle.T]
    names = [f"p{k + 1}" for k in range(count)]
    chain = chain_of(truth, *equal_spacing(truth, names)[1:])
    place = chain(np.column_stack([*pose, *angle]))[0]
    place = place + NOISE * random.standard_normal(place.shape)
    rows = np.column_stack([seen - seen[0], place.reshape(len(seen), -1)])
    head = "time_s," + ",".join(f"{axis}{k + 1}" for k in range(count) for axis in "xy")
    np.savetxt(file, rows, delimiter=",", header=head, comments="", fmt="%.7g")


def seen(robot: ht.Robot, truth: ht.Robot, shape: str, begin: str, runs: Sequence[int], seed: int) -> list[Trials]:
    """Return trials of a robot's runs, one for each, from simulated markers."""
    trials = []
    with tempfile.TemporaryDirectory() as folder:
        for k in runs:
            file = Path(folder) / f"run{k}.csv"
            tracked(truth, gait_of(truth, *SHAPES[shape][3][k]), begin, np.random.default_rng([seed, k]), file)
            write_marker_runs([read_marker_run(robot, file)], robot, file.with_suffix(".toml"), "synthetic")
            trials.append(read_trials(file.with_suffix(".toml"), robot))
    return trials


def held_out(shape: str, law: str, begin: str, shedding: float = 1.0) -> dict[str, Any]:
    """Fit three runs, predict two; return errors [%] of the replayed travel and of the settled gait's speed."""
    robot = described(shape, handbook(len(SHAPES[shape][0]), tail_shedding=shedding))
    truth = truth_of(shape, law)
    runs = seen(robot, truth, shape, begin, (*TRAINED, *HELD), seed=1)
    fit = identify(robot, runs[0] + runs[1] + runs[2], validate=0, threads=1)
    row: dict[str, Any] = {"kind": "held out", "robot": shape, "swims": law, "begin": begin, "tail_shedding": shedding}
    for name, fish in (("described", robot), ("fitted", fit.robot)):
        travel, speed, path = [], [], []
        for k, trials in zip(HELD, runs[3:], strict=True):
            (recording,) = trials.recordings
            result = ht.replay_recording(fish, recording)
            compared = ht.compare_recording(fish, recording, result)
            path.append(float(np.hypot(*compared.rmse.to_numpy()[:2])) / fish.body.length)
            pose = recording.tracks[0].pose[:, :2]
            end = float(np.linalg.norm(_center(fish, result, recording.tracks[0].time[-1])))
            travel.append(100 * (end / float(np.linalg.norm(pose[-1] - pose[0])) - 1))
            gait = ht.Gaits.of([gait_of(fish, *SHAPES[shape][3][k])])
            own, other = (settle(one, gait)["speed"][0] for one in (fish, truth))
            speed.append(100 * float(own / other - 1))
        row[name] = {"travel_percent": travel, "settled_speed_percent": speed, "path_rmse_lengths": path}
    return row | {"warnings": list(fit.warnings), "values": fit.values.tolist()}


def _center(robot: ht.Robot, result: Any, until: float) -> Any:
    """Return the displacement (2,) [m] of the head's center from the start of a replay."""
    half, heading = robot.links.length[0] / 2, result["heading"].to_numpy()
    x = result["x"].to_numpy() + half * np.cos(heading)
    y = result["y"].to_numpy() + half * np.sin(heading)
    time = result["time"].to_numpy()
    return np.array([np.interp(until, time, axis) - axis[0] for axis in (x, y)])


def covered(shape: str, begin: str, seed: int, priors: bool = True) -> dict[str, Any]:
    """Fit three runs with the true law; return relative errors, and half-widths of 90 % intervals."""
    robot, truth = described(shape, handbook(len(SHAPES[shape][0]))), truth_of(shape, "same law")
    first, *others = seen(robot, truth, shape, begin, TRAINED, seed)
    trials, own = first + others[0] + others[1], None if priors else {}
    fit = identify(robot, trials, validate=0, starts=1, threads=1, prior=own)
    known = np.array([4.0, 0.7, 1.4])  # factors on drag along and across, and on added mass
    half = stdtrit(fit.uncertainty.freedom, 0.95) * np.sqrt(np.diag(fit.uncertainty.covariance))
    middle = to_scale(fit.free, fit.values)
    low, high = (from_scale(fit.free, middle + side * half) for side in (-1, 1))
    kind = "coverage" if priors else "without priors"
    row = {"kind": kind, "robot": shape, "begin": begin, "seed": seed, "error": (fit.values / known - 1).tolist()}
    held = ((low <= known) & (known <= high)).tolist()
    return row | {"half_width": ((high - low) / (2 * known)).tolist(), "held": held}


def main() -> None:
    """Run the study; finished fits are stored, so that an interrupted study continues."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, default=Path(__file__).with_suffix(".json"))
    output = parser.parse_args().output
    done = json.loads(output.read_text())["runs"] if output.exists() else []
    eel, _, fish, _ = SHAPES
    shed, elongated = list(LAWS)[1:]
    jobs: list[Any] = [(held_out, (shape, shed, "motion")) for shape in SHAPES]
    jobs += [(held_out, (shape, elongated, "motion")) for shape in (eel, fish)]
    jobs += [(held_out, (fish, law, "motion", 0.0)) for law in (shed, elongated)]
    jobs += [(held_out, (eel, shed, "rest"))]
    jobs += [(covered, (eel, "motion", seed)) for seed in COVERED]
    jobs += [(covered, (eel, "motion", seed, False)) for seed in WITHOUT]
    known = [run["job"] for run in done]
    for work, arguments in jobs:
        if list(arguments) in known:
            continue
        done.append({"job": arguments} | work(*arguments))
        about = {"made_by": "python validation/identify/strangers.py", "hypertuna": version(), "noise_m": NOISE}
        output.write_text(json.dumps(about | {"runs": done}, indent=1) + "\n")
        print(done[-1], flush=True)


if __name__ == "__main__":
    main()
