"""Make tracked markers as a camera would see them: three swims of a robot eel's model, in motion at the first frame.

`python make.py` writes slow.csv, middle.csv and fast.csv beside itself: pixels of 1 mm, y down, with seeded noise,
markers out of sight and one that is taken for another. The eel of the swims has 1.3 times the drag of `rexeel`.
"""

import sys
from pathlib import Path

import numpy as np

import hypertuna as ht
from hypertuna.identification.coefficients import free, with_values
from hypertuna.trials.chain import chain_of
from hypertuna.trials.marker_places import equal_spacing

SEED = 1
NOISE = 0.0003  # m, of a coordinate
LOST = 0.03  # of the markers
FRAME_RATE = 30.0  # Hz
MARKERS = 12
PIXEL = 0.001  # m

described = ht.load("rexeel")
drags = free(described, ["water.drag_normal=common", "water.drag_tangential=common"])
eel = with_values(described, drags, [1.3, 1.3])
random = np.random.default_rng(SEED)
folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent
names = [f"p{k + 1}" for k in range(MARKERS)]
chain = chain_of(eel, *equal_spacing(eel, names)[1:])

for name, frequency, amplitude in (("slow", 0.4, 20), ("middle", 0.6, 25), ("fast", 0.8, 20)):
    # Two beats to gain speed, then three seconds that the camera sees.
    time = np.arange(round((2 / frequency + 3.0) * 2 * FRAME_RATE) + 1) / (2 * FRAME_RATE)
    wave = np.sin(2 * np.pi * frequency * time[:, np.newaxis] - np.radians(50.4) * np.arange(5))
    series = ht.JointSeries(time, np.clip(time, 0, 1)[:, np.newaxis] ** 3 * np.radians(amplitude) * wave)
    swim = ht.replay(eel, ht.smooth(series, noise=0.0), start=ht.Pose(0.9, 0.4, 0.3))
    seen = time[time >= time[-1] - 3.0][::2]
    pose = [np.interp(seen, swim.time, swim[axis]) for axis in ("x", "y", "heading")]
    angle = [np.interp(seen, time, column) for column in series.angle.T]
    place = chain(np.column_stack([*pose, *angle]))[0] + NOISE * random.standard_normal((len(seen), MARKERS, 2))
    place[30, [2, 7]] = place[30, [7, 2]]
    place[random.random(place.shape[:2]) < LOST] = np.nan
    pixels = place / PIXEL * [1, -1] + [0, 1200]
    lines = ["time_s," + ",".join(f"{axis}{k + 1}" for k in range(MARKERS) for axis in "xy")]
    for t, row in zip(seen - seen[0], pixels.reshape(len(seen), -1), strict=True):
        lines.append(",".join([f"{t:.4f}", *("" if np.isnan(x) else f"{x:.1f}" for x in row)]))
    (folder / f"{name}.csv").write_text("\n".join(["# synthetic: made by make.py", *lines]) + "\n", encoding="utf-8")
