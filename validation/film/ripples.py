"""Errors and intervals of tracked films with ripples: python validation/film/ripples.py [SEEDS] [FIRST] [FOLDER].

Films of the settled cruise of examples/minnow.toml, six beats at 60 frames/s, a fish of 200 px; ripples of 0.7 px and
caustics of 6 % drawn anew by every seed, noise of 3 gray levels, H.264 at crf 26. Place and heading at the start
are drawn, too. Results are added to seeds.json beside this file, a line a seed; seeds that are there are not computed
again. Films stay in FOLDER, if there is one, and are not drawn again.
"""

import json
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import hypertuna as ht

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tests"))

from film.rendered import Eye, Scene, frames, moved, swim_motion, write_film  # noqa: E402
from film.small import DEPTH, camera, fish, sections  # noqa: E402
from hypertuna.film.run import track_film  # noqa: E402

EYE = Eye(size=(1120, 480), focal=1100.0, k1=-0.12, place=(0.0, 0.0, 1.6))  # the camera
RATE, SECONDS, RIPPLE = 60, 2.5, 0.7  # frames per second; length of a film [s]; ripples [px rms]
RESULT = Path(__file__).parent / "seeds.json"


def shown(seed, keep=None, ripple=RIPPLE, crf=26, **scene):
    """Render and track a film; return the tracked run, each frame's truth and the processor time of tracking [s]."""
    robot, draw = ht.load(ROOT / "examples/minnow.toml"), np.random.default_rng(seed)
    turn = draw.uniform(-0.15, 0.15) + (np.pi if seed % 2 else 0.0)
    offset = (draw.uniform(0.4, 0.45) if seed % 2 == 0 else draw.uniform(-0.45, -0.4), draw.uniform(-0.06, 0.06))
    motion = moved(swim_motion(ht.swim(robot, "cruise")), offset, turn)
    times = np.arange(round(SECONDS * RATE)) / RATE
    scene = {"caustics": 0.06, **scene}
    setting = Scene(EYE, fish(), depth=DEPTH, rate=RATE, ripple=ripple, seed=seed, **scene)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(keep or folder) / f"seed{seed}.mp4"
        if not path.exists():
            write_film(part := path.with_suffix(".part.mp4"), frames(setting, motion, times), rate=RATE, crf=crf)
            part.rename(path)
        file = sections(fish(), Path(folder) / "sections.csv")
        begin = time.process_time()
        run = track_film(robot, path, camera(EYE), depth=DEPTH, sections=file)
    return run, np.array([np.concatenate(motion(t)) for t in times]), time.process_time() - begin


def errors(run, truth):
    """Return errors of a tracked run, and how often its intervals hold the truth."""
    own = np.concatenate(run.stretches)
    half, length = run.body.length[0] / 2, run.body.length.sum()
    x, y, heading = truth[:, :3].T
    head = np.column_stack([x + half * np.cos(heading), y + half * np.sin(heading), heading + np.pi])
    off = (run.head - head)[own]
    off[:, 2] = (off[:, 2] + np.pi) % (2 * np.pi) - np.pi
    joints = (run.angle - truth[:, 3:])[own]
    beat = None if run.beat is None else np.degrees(run.beat.angle(run.tracked.time[own]) - truth[own, 3:])

    def rms(values):
        return np.round(np.sqrt((values**2).mean(axis=0)), 4).tolist()

    return {
        "frames": len(own),
        "head_percent": round(float(100 * np.sqrt((off[:, :2] ** 2).sum(axis=1).mean()) / length), 4),
        "yaw_deg": rms(np.degrees(off[:, 2])),
        "joints_deg": rms(np.degrees(joints)),
        "periodic_deg": None if beat is None else rms(beat),
        "cover_joints": np.round((np.abs(joints) < 1.96 * run.angle_sd[own]).mean(axis=0), 4).tolist(),
        "cover_head": np.round((np.abs(off) < 1.96 * run.head_sd[own]).mean(axis=0), 4).tolist(),
        "size": round(run.size, 5),
        "tau_s": round(run.memory, 4),
    }


def main(seeds=20, first=0, keep=None):
    lines = json.loads(RESULT.read_text()) if RESULT.exists() else {}
    for seed in range(int(first), int(first) + int(seeds)):
        if str(seed) in lines:
            continue
        run, truth, spent = shown(seed, keep)
        lines[str(seed)] = errors(run, truth) | {"ms_a_frame": round(1e3 * spent / len(truth), 1)}
        RESULT.write_text("{\n" + ",\n".join(f'"{k}": {json.dumps(v)}' for k, v in lines.items()) + "\n}\n")
        print(seed, lines[str(seed)], flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
