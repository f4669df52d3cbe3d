"""Films that a tracker may get wrong: python validation/film/hostile.py [NAME ...].

Small films of the minnow at 60 frames/s, each with one thing that goes wrong. What comes of each is written to
hostile.json beside this file: the errors of those that are tracked, or the sentence of those that are refused.
"""

import json
import sys
import tempfile
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from functools import cache
from pathlib import Path

import av
import cv2
import numpy as np

import hypertuna as ht

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tests"))

from film.rendered import Scene, frames, write_film  # noqa: E402
from film.small import DEPTH, EYE, ROBOT, beating, camera, fish, sections  # noqa: E402
from hypertuna.errors import InputError  # noqa: E402
from hypertuna.film.calibrate import calibrate  # noqa: E402
from hypertuna.film.pace import pace_warnings  # noqa: E402
from hypertuna.film.run import track_film  # noqa: E402

RESULT = Path(__file__).parent / "hostile.json"
COUNT, RATE = 60, 60  # frames of a film; frames per second
RIGHT = (1.5, 0.01)  # rms errors below which a result is right: of joints [deg], of the head [body lengths]


@cache
def plain():
    """Return frames of the fish in calm water."""
    return tuple(_drawn())


def drawn(*args, **scene):
    """Return frames of a scene as a list, for more to be drawn onto them."""
    return _drawn(*args, **scene) if args or scene else [picture.copy() for picture in plain()]


def _drawn(motion=beating, count=COUNT, shape=None, **scene):
    setting = Scene(EYE, shape or fish(), depth=DEPTH, rate=RATE, **scene)
    return [*frames(setting, motion, np.arange(count) / RATE)]


def shifted(offset, count=COUNT, **scene):
    """Return frames of the fish, moved by an offset (3,) [m, m, rad]."""
    return drawn(lambda t: (beating(t)[0] + offset, beating(t)[1]), count, **scene)


def phone(
    path, pictures, codec="libx265", pix_fmt="yuv420p", rate=RATE, first=0, turn=None, options=(), tags=(), kept=None
):
    """Write a film as phones do: variable times of frames, a rotation, tags of the maker."""
    container = {"avoid_negative_ts": "disabled", "movflags": "use_metadata_tags"}
    with av.open(str(path), "w", options=container) as out:
        out.metadata.update(dict(tags))
        stream = out.add_stream(codec, rate=rate, options={"crf": "18", "preset": "veryfast", **dict(options)})
        (stream.height, stream.width), stream.pix_fmt = pictures[0].shape, pix_fmt
        if codec == "libx265":
            stream.options = {**stream.options, "x265-params": "log-level=none"}
        if turn is not None:
            stream.set_display_rotation(turn)
        for k, picture in zip(range(len(pictures)) if kept is None else kept, pictures, strict=True):
            frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format="gray").reformat(format=pix_fmt)
            frame.pts, frame.time_base = int(k) + first, Fraction(1, rate)
            out.mux(stream.encode(frame))
        out.mux(stream.encode(None))


def damaged(path):
    write_film(path, drawn())
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def joined(path):
    """Write a film joined from two takes, between which the fish jumps."""
    write_film(path, [*drawn()[:30], *shifted([0.06, -0.08, 0.0], 60)[30:]])


def variable(path):
    times = np.cumsum(np.random.default_rng(0).uniform(0.008, 0.03, COUNT))
    write_film(path, drawn(), times=times)


def lost(path):
    kept = np.delete(np.arange(COUNT), [20, 21, 40])
    phone(path, [drawn()[k] for k in kept], "libx264", kept=kept)


def finless(path):
    whole = fish()
    cut = {"half_width": whole.half_width[:240], "half_height": whole.half_height[:240]}
    write_film(path, drawn(shape=replace(whole, length=whole.length[:3], share=whole.share[:3], **cut)))


def stamped(path):
    """Write a film with a clock and a logo in the picture, as surveillance cameras do."""
    pictures = drawn()
    for k, picture in enumerate(pictures):
        cv2.putText(picture, f"12:30:{k / 60:05.2f}", (8, 22), cv2.FONT_HERSHEY_SIMPLEX, 0.7, 20, 2)
        cv2.rectangle(picture, (430, 240), (475, 265), 30, -1)
    write_film(path, pictures)


def overlaid(path):
    """Write a film with a logo where the fish swims."""
    pictures = drawn()
    for picture in pictures:
        cv2.rectangle(picture, (150, 110), (230, 150), 60, -1)
    write_film(path, pictures)


def flickering(path):
    """Write a film in which lamps at 50 Hz modulate the light by 10 % at 60 frames per second."""
    light = 1 + 0.1 * np.sin(2 * np.pi * 100 * np.arange(COUNT) / 60)
    write_film(path, [np.clip(p * b, 0, 255).astype(np.uint8) for p, b in zip(drawn(), light, strict=True)])


def swaying(path):
    """Write a film whose camera is moved by 6 px, and back."""
    steps = [np.rint(6 * np.sin(2 * np.pi * k / 80)) for k in range(COUNT)]
    moves = [np.float32([[1, 0, s], [0, 1, 0.5 * s]]) for s in steps]
    write_film(path, [cv2.warpAffine(p, m, p.shape[::-1], borderMode=cv2.BORDER_REPLICATE)
                      for p, m in zip(drawn(), moves, strict=True)])  # fmt: skip


def hand(path):
    """Write a film in which a hand as dark as the fish reaches in for a third of the time."""
    pictures = drawn()
    for k in range(20, 40):
        deep = int(110 * np.sin(np.pi * (k - 20) / 20))
        cv2.rectangle(pictures[k], (220, 0), (300, deep), 60, -1)
        for finger in range(4):
            cv2.line(pictures[k], (228 + 20 * finger, deep), (224 + 22 * finger, deep + 40), 60, 12)
    write_film(path, pictures)


def touching(path):
    """Write a film in which a second fish is so near that both are one dark area for half of the time."""
    both = zip(drawn(noise=0.0), shifted([0.02, -0.05, 0.25], noise=0.0), strict=True)
    write_film(path, [np.minimum(a, b) for a, b in both])


def apart(path):
    both = zip(drawn(noise=0.0), shifted([0.05, -0.17, 0.0], noise=0.0), strict=True)
    write_film(path, [np.minimum(a, b) for a, b in both])


def large(path):
    write_film(path, [cv2.resize(p, None, fx=8, fy=8, interpolation=cv2.INTER_CUBIC) for p in drawn()[:48]])


def doubled(path):
    pictures = drawn()
    write_film(path, [pictures[k - k % 2] for k in range(COUNT)])


def blended(path):
    """Write a film in which every second frame is the mean of its neighbors, as of an interpolated frame rate."""
    pictures = drawn()[: COUNT - 1]
    write_film(path, [pictures[k - k % 2] // 2 + pictures[k + k % 2] // 2 for k in range(len(pictures))])


SLOW = {"com.android.capture.fps": "240.0"}  # tag of a film in slow motion: true frames per second
# name: what writes the film; whether it is a mirror image, a portrait, of 4K, upside down; options of `track_film`
FILMS: dict[str, tuple[Callable[[Path], None], dict]] = {
    "cable over the fish": (lambda path: write_film(path, drawn(cable=True)), {}),
    "second fish, apart": (apart, {"other": True}),
    "second fish, touching": (touching, {"other": True}),
    "hand in the picture": (hand, {}),
    "empty tank": (lambda path: write_film(path, shifted([9.0, 0.0, 0.0])), {}),
    "fish that stays": (lambda path: write_film(path, drawn(lambda t: beating(t, speed=0.1))), {}),
    "fish that leaves": (lambda path: write_film(path, shifted([-0.33, 0.0, 0.0])), {"offset": -0.33}),
    "upside down": (lambda path: write_film(path, [p[::-1, ::-1] for p in drawn()]), {"down": True}),
    "mirrored, outline alone": (lambda path: write_film(path, [p[:, ::-1] for p in drawn()]), {"mirrored": True}),
    "mirrored, corners of the tank": (
        lambda path: write_film(path, [p[:, ::-1] for p in drawn()]), {"mirrored": True, "corners": True}),
    "file cut in the middle": (damaged, {}),
    "two takes in one film": (joined, {"jump": True}),
    "variable rate": (variable, {}),
    "lost frames": (lost, {}),
    "doubled frames": (doubled, {}),
    "interpolated frames": (blended, {}),
    "pale fish": (lambda path: write_film(path, drawn(dark=168.0)), {}),
    "fin that is not seen": (finless, {}),
    "clock and logo in the picture": (stamped, {}),
    "logo over the way": (overlaid, {}),
    "flickering lamps": (flickering, {}),
    "camera that moves": (swaying, {}),
    "portrait, HEVC": (lambda path: phone(path, [np.rot90(p, -1) for p in drawn()], turn=90), {}),
    "10 bits, HEVC": (lambda path: phone(path, drawn(), pix_fmt="yuv420p10le"), {}),
    "4K": (large, {"factor": 8}),
    "interlaced": (lambda path: phone(path, drawn(), "libx264", options={"x264-params": "interlaced=1"}), {}),
    "trimmed on the phone": (lambda path: phone(path, drawn(), "libx264", first=-10), {"begin": 10}),
    "slow motion, rate in the file": (lambda path: phone(path, drawn(), "libx264", 'yuv420p', 15, tags={
        "com.android.capture.fps": "60.0"}), {}),
    "slow motion, no rate": (lambda path: phone(path, drawn(), "libx264", rate=Fraction(15, 2)), {"slow": 8}),
    "another size than the camera's": (
        lambda path: write_film(path, [cv2.resize(p, (240, 136)) for p in drawn()]), {}),
}  # fmt: skip


def seen_by(scene):
    """Return the camera of a film."""
    eye = EYE
    if scene.get("down"):
        eye = replace(eye, place=(-eye.place[0], -eye.place[1], eye.place[2]))
    if scene.get("mirrored"):
        eye = replace(eye, place=(-eye.place[0], *eye.place[1:]))
    if factor := scene.get("factor"):
        eye = replace(eye, size=tuple(factor * n for n in eye.size), focal=factor * eye.focal)
    return camera(eye)


def truth_at(time, scene):
    """Return the true head's center (x, y) and joint angles of a film at times [s]."""
    rows = []
    for t in time / scene.get("slow", 1) + scene.get("begin", 0) / RATE:
        (x, y, heading), angle = beating(t)
        x += scene.get("offset", 0.0)
        if scene.get("jump") and t > 29.5 / RATE:
            x, y = x + 0.06, y - 0.08
        half = fish().length[0] / 2
        rows.append([x + half * np.cos(heading), y + half * np.sin(heading), *angle])
    rows = np.array(rows)
    return rows * [-1, -1, 1, 1, 1] if scene.get("down") else rows


def mirrored_corners(path):
    """Write the corners of a tank as a mirrored film shows them."""
    places = np.array([[-0.25, 0.1], [0.25, 0.1], [0.25, -0.1], [-0.25, -0.1]])
    pixels = camera(EYE).pixels(places, 0.0)
    rows = [f"{EYE.size[0] - 1 - u:.2f},{v:.2f},{x},{y}" for (u, v), (x, y) in zip(pixels, places, strict=True)]
    path.write_text("\n".join(["u_px,v_px,x_m,y_m", *rows]) + "\n")
    return path


def outcome(name):
    """Draw and track a film; return what came of it."""
    write, scene = FILMS[name]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"film.{'mov' if 'HEVC' in name else 'mp4'}"
        write(path)
        own = {"depth": DEPTH, "sections": sections(fish(), Path(folder) / "sections.csv")}
        try:
            if scene.get("corners"):
                calibrate(size=EYE.size, corners=mirrored_corners(Path(folder) / "corners.csv"), height=EYE.place[2])
            run = track_film(ht.load(ROBOT), path, seen_by(scene), **own)
        except InputError as error:
            return {"name": name, "outcome": "refused", "sentence": str(error).replace(f"{folder}/", "")}
    used = np.concatenate(run.stretches)
    truth = truth_at(run.tracked.time[used], scene)
    if scene.get("other") and np.median(truth[:, 1] - run.head[used, 1]) > 0.1:  # either fish is right
        truth += [0.05, -0.17, 0.0, 0.0, 0.0]
    joints = np.degrees(np.sqrt(((run.angle[used] - truth[:, 2:]) ** 2).mean(axis=0)))
    head = np.linalg.norm(run.head[used, :2] - truth[:, :2], axis=1) / fish().length.sum()
    doubts = pace_warnings(ht.load(ROBOT), run.beat and run.beat.frequency, run.view.film.rate)
    facts = {"joints_deg": joints.round(2).tolist(), "head": round(float(np.sqrt((head**2).mean())), 4)}
    facts |= {"used": len(used), "frames": len(run.tracked.time)}
    facts |= {"beat_hz": None if run.beat is None else round(run.beat.frequency, 3)}
    right = (joints < RIGHT[0]).all() and facts["head"] < RIGHT[1]
    moves = any("the tank moves" in sentence for sentence in run.warnings)
    # doubts: all times are those of slow motion
    found = "told" if doubts or moves else "right" if right else "off"
    return {"name": name, "outcome": found, "told": run.warnings + doubts} | facts


def main(names):
    """Track films, and store each one's outcome in the file."""
    known = {one["name"]: one for one in json.loads(RESULT.read_text())} if RESULT.exists() else {}
    for name in names or FILMS:
        known[name] = outcome(name)
        print(json.dumps(known[name]), flush=True)
        RESULT.write_text("[\n" + ",\n".join(json.dumps(known[k]) for k in FILMS if k in known) + "\n]\n")


if __name__ == "__main__":
    main(sys.argv[1:])
