"""From film to the speed of an unseen gait: python validation/film/story.py [SEEDS] [FIRST].

A hidden minnow, whose drag along, drag across and added mass differ from those of its file, is filmed in ripples at
three gaits and in a turn. The films are tracked, `identify` fits the file to them, and the speed of gaits that were not
filmed is predicted. Results are added to story.json beside this file, a line a seed.
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

HIDDEN = {"drag_tangential": 2.0, "drag_normal": 0.667, "added_mass_normal": 1.25}  # factors on the file's values
FILMED = {"cruise": (2.5, 0.0, 3.0), "slow": (1.5, 0.0, 5.0), "fast": (4.0, 0.0, 2.0), "turn": (2.5, 8.0, 3.0)}
# Frequency [Hz], factors on amplitudes and phase lags: at one shape of the gait all speeds go with the frequency.
UNSEEN = ((2.0, 1.0, 1.0), (2.0, 0.6, 1.0), (3.0, 1.0, 0.5), (1.5, 0.8, 1.5), (3.5, 0.5, 0.7))
RESULT = Path(__file__).parent / "story.json"


def hidden(robot):
    """The robot that is filmed."""
    document = robot.document()
    for key, factor in HIDDEN.items():
        document["water"]["strip"][key] = [factor * value for value in document["water"]["strip"][key]]
    return parse(document, file="hidden")


def gait(robot, frequency, bias=0.0, swing=1.0, lag=1.0):
    """The gait of the cruise at another frequency, bent by `bias` [deg], with factors on its amplitudes and phases."""
    cruise = ht.named_gait(robot, "cruise")
    amplitude, phase = swing * np.array(cruise.amplitude), lag * np.array(cruise.phase)
    return ht.Gait(frequency, tuple(amplitude), tuple(phase), (np.radians(bias),) * len(amplitude))


def filmed(folder, name, robot, truth, seed):
    """Film the hidden robot, and track it; return the manifest."""
    frequency, bias, seconds = FILMED[name]
    motion = moved(swim_motion(ht.swim(truth, gait(robot, frequency, bias))), (0.42, -0.05), 0.1)
    times = np.arange(round(seconds * RATE)) / RATE
    scene = Scene(EYE, fish(), depth=DEPTH, rate=RATE, ripple=RIPPLE, caustics=0.06, seed=seed)
    film, manifest = folder / f"{name}.mp4", folder / f"{name}.toml"
    write_film(film, frames(scene, motion, times), rate=RATE)
    run = track_film(robot, film, camera(EYE), depth=DEPTH, sections=sections(fish(), folder / "sections.csv"))
    write_film_run(run, robot, manifest, "a film of the hidden minnow")
    return manifest


def story(seed):
    """Fit the file to the films of a seed; return the coefficients with their intervals, and the errors of speeds."""
    robot = ht.load(ROOT / "examples/minnow.toml")
    truth = hidden(robot)
    with tempfile.TemporaryDirectory() as place:
        manifests = [filmed(Path(place), name, robot, truth, 100 * seed + k) for k, name in enumerate(FILMED)]
        fit = ht.identify(robot, ht.read_trials([str(path) for path in manifests], robot), validate=0)
    speeds = {}
    for frequency, swing, lag in UNSEEN:
        unseen = gait(robot, frequency, swing=swing, lag=lag)
        before, after, true = (ht.swim(one, unseen).speed for one in (robot, fit.robot, truth))
        name = f"{frequency:g} Hz, {swing:g} of the amplitudes, {lag:g} of the lags"
        speeds[name] = {"file": round(100 * (before / true - 1), 2), "fit": round(100 * (after / true - 1), 2)}
    parts = {
        name: [round(float(part[key]), 4) for key in ("value", "low", "high")]
        for name, part in zip(HIDDEN, fit.parameters, strict=True)
    }
    return {"factors": parts, "speed_error_percent": speeds, "warnings": list(fit.warnings)}


def main(seeds=1, first=0):
    lines = json.loads(RESULT.read_text()) if RESULT.exists() else {}
    for seed in range(first, first + seeds):
        lines[str(seed)] = story(seed)
        RESULT.write_text("{\n" + ",\n".join(f'"{k}": {json.dumps(v)}' for k, v in lines.items()) + "\n}\n")
        print(seed, json.dumps(lines[str(seed)], indent=1), flush=True)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
