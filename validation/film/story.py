"""From film to the speed of an unseen gait: python validation/film/story.py [SEEDS] [FIRST] [tracks].

A hidden minnow, whose drag along, drag across and added mass differ from those of its file, is filmed in ripples at
three gaits and in a turn. The films are tracked, `identify` fits the file to them, and the speed of gaits that were not
filmed is predicted. Results are added to story.json beside this file, a line a seed; seeds that it has are left out.

With `tracks`, nothing is filmed: the true angles and poses get noise of the size and memory that tracked films of the
same ripples had (medians of seeds.json), independent from joint to joint. It takes a tenth of the time, and shows
nothing of the tracker. Results are in tracks.json.
"""

import json
import sys
import tempfile
from pathlib import Path

import numpy as np
from ripples import EYE, RATE, RIPPLE, ROOT

import hypertuna as ht
from film.rendered import Scene, frames, moved, swim_motion, write_film
from film.small import DEPTH, camera, fish, sections
from hypertuna.description.robot import parse
from hypertuna.film.run import track_film, write_film_run
from hypertuna.trials.marker_import import write_recording
from hypertuna.trials.pose_import import manifest_text

HIDDEN = {"drag_tangential": 2.0, "drag_normal": 0.667, "added_mass_normal": 1.25}  # factors on the file's values
# Runs that are filmed: frequency [Hz], bias [deg], duration [s]
FILMED = {"cruise": (2.5, 0.0, 3.0), "slow": (1.5, 0.0, 5.0), "fast": (4.0, 0.0, 2.0), "turn": (2.5, 8.0, 3.0)}
# Frequency [Hz], factors on amplitudes and phase lags, which vary as the frequency alone only scales the speed.
UNSEEN = ((2.0, 1.0, 1.0), (2.0, 0.6, 1.0), (3.0, 1.0, 0.5), (1.5, 0.8, 1.5), (3.5, 0.5, 0.7))
ANGLE_NOISE, HEAD_NOISE, MEMORY = (
    np.radians([1.6, 1.8, 1.5]),
    np.array([9e-4, 9e-4, np.radians(0.85)]),
    0.125,
)  # of joints [rad]; of the head [m, m, rad]; correlation time of both [s]


def hidden(robot):
    """Return the robot that is filmed."""
    document = robot.document()
    for key, factor in HIDDEN.items():
        document["water"]["strip"][key] = [factor * value for value in document["water"]["strip"][key]]
    return parse(document, file="hidden")


def gait(robot, frequency, bias=0.0, swing=1.0, lag=1.0):
    """Return the gait "cruise" at another frequency, with a bias [deg] and factors on its amplitudes and phases."""
    cruise = ht.named_gait(robot, "cruise")
    amplitude, phase = swing * np.array(cruise.amplitude), lag * np.array(cruise.phase)
    return ht.Gait(frequency, tuple(amplitude), tuple(phase), (np.radians(bias),) * len(amplitude))


def swum(name, robot, truth):
    """Return the hidden robot's motion in a run, and the times of the frames [s]."""
    frequency, bias, seconds = FILMED[name]
    motion = moved(swim_motion(ht.swim(truth, gait(robot, frequency, bias))), (0.42, -0.05), 0.1)
    return motion, np.arange(round(seconds * RATE)) / RATE


def disturbed(folder, name, robot, truth, seed):
    """Write the hidden robot's true motion with a tracker's noise; return the entry for the manifest."""
    motion, times = swum(name, robot, truth)
    draw, kept = np.random.default_rng(seed), np.exp(-1 / (RATE * MEMORY))
    noise = draw.standard_normal((len(times), 6))
    for k in range(1, len(noise)):
        noise[k] = kept * noise[k - 1] + np.sqrt(1 - kept**2) * noise[k]
    sd = np.tile(np.concatenate([HEAD_NOISE, ANGLE_NOISE]), (len(times), 1))
    found = np.array([np.concatenate(motion(t)) for t in times])
    half = robot.links.length[0] / 2
    found[:, :2] += half * np.column_stack([np.cos(found[:, 2]), np.sin(found[:, 2])])
    found[:, 2] += np.pi
    found += sd * noise
    groups = [group.name for group in robot.joints]
    entry, _ = write_recording(
        folder, name, groups, times, found[:, 3:], sd[:, 3:], found[:, :3], sd[:, :3], comment="noise of a tracker"
    )
    entry["joints"] |= {"noise_deg": np.degrees(ANGLE_NOISE).tolist(), "noise_tau_s": MEMORY}
    manifest = folder / f"{name}.toml"
    manifest.write_text(manifest_text({"format": 1, "robot": robot.name, "recordings": [entry]}, "noise of a tracker"))
    return manifest


def filmed(folder, name, robot, truth, seed):
    """Film the hidden robot, and track it; return the entry for the manifest."""
    motion, times = swum(name, robot, truth)
    scene = Scene(EYE, fish(), depth=DEPTH, rate=RATE, ripple=RIPPLE, caustics=0.06, seed=seed)
    film, manifest = folder / f"{name}.mp4", folder / f"{name}.toml"
    write_film(film, frames(scene, motion, times), rate=RATE)
    run = track_film(robot, film, camera(EYE), depth=DEPTH, sections=sections(fish(), folder / "sections.csv"))
    write_film_run(run, robot, manifest, "a film of the hidden minnow")
    return manifest


def story(seed, made=filmed):
    """Fit the file to the films of a seed; return the coefficients with their intervals, and the errors of speeds."""
    robot = ht.load(ROOT / "examples/minnow.toml")
    truth = hidden(robot)
    with tempfile.TemporaryDirectory() as place:
        manifests = [made(Path(place), name, robot, truth, 100 * seed + k) for k, name in enumerate(FILMED)]
        fit = ht.identify(robot, ht.read_trials([str(path) for path in manifests], robot), validate=0)
        warnings = [text.replace(f"{place}/", "") for text in fit.warnings]
    speeds = {}
    for frequency, swing, lag in UNSEEN:
        unseen = gait(robot, frequency, swing=swing, lag=lag)
        before, after, true = (ht.swim(one, unseen).speed for one in (robot, fit.robot, truth))
        name = f"{frequency:g} Hz, {swing:g} of the amplitudes, {lag:g} of the lags"
        speeds[name] = {"file": round(100 * (before / true - 1), 2), "fit": round(100 * (after / true - 1), 2)}
    parts = {
        name: [round(float(part[key]), 4) for key in ("value", "low", "high")]
        for name, part in ((name, part) for name in HIDDEN for part in fit.parameters if f".{name}[" in part["name"])
    }
    return {"factors": parts, "speed_error_percent": speeds, "warnings": warnings}


def main(seeds="1", first="0", how="story"):
    result = Path(__file__).parent / f"{how}.json"
    lines = json.loads(result.read_text()) if result.exists() else {}
    for seed in range(int(first), int(first) + int(seeds)):
        if str(seed) not in lines:
            lines[str(seed)] = story(seed, {"story": filmed, "tracks": disturbed}[how])
            result.write_text("{\n" + ",\n".join(f'"{k}": {json.dumps(v)}' for k, v in lines.items()) + "\n}\n")
            print(seed, json.dumps(lines[str(seed)], indent=1), flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
