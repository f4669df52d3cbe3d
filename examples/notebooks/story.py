# %% [markdown]
# # From film to the next run
#
# A fish differs from its file, and nobody knows how. A camera above the tank films it, `track_film` finds its joint
# angles and its path, `identify` fits the file to them, and a design says what to film next. It ends when the design
# knows the speeds of the gaits in its range within 8 %. The speed of a gait that was not filmed should then be right
# within 5 %.
#
# Here the films are drawn: the model swims a hidden fish, which only the next cell knows. Put your films in place of
# `film`. This notebook needs the extra `film`.

# %%
# !hypertuna robot new fish.toml --links 4 --actuation servo

# %%
import av
import cv2
import numpy as np

import hypertuna as ht
from hypertuna.description.robot import parse
from hypertuna.film.camera import Camera
from hypertuna.film.run import track_film, write_film_run
from hypertuna.film.sections import body_of

robot = ht.load("fish.toml")
document, factors = robot.document(), {"drag_tangential": 2.0, "drag_normal": 0.667, "added_mass_normal": 1.25}
for key, factor in factors.items():
    document["water"]["strip"][key] = [factor * value for value in document["water"]["strip"][key]]
hidden = parse(document, file="hidden")
robot

# %% [markdown]
# The camera looks straight down from 1.6 m, and films 60 frames a second of 480 by 272 pixels. The fish is drawn as
# the outline of the sections of its file, with noise.

# %%
RATE, DEPTH = 60, 0.08  # frames per second, m
BEATS, LENGTHS = 5, 1.8  # that a film shows at least
camera = Camera(width_px=480, height_px=272, focal_px=640.0, center_px=(239.5, 135.5), place_m=(0.0, 0.0, 1.6))
body = body_of(robot)


def outline(pose, bend):
    """Return the outline (points, 2) [m] of the fish by the pose of its nose and the angles of its joints."""
    turn = pose[2] + body.share @ bend
    ahead = np.column_stack([np.cos(turn), np.sin(turn)])
    joints = pose[:2] + np.vstack([np.zeros(2), np.cumsum(body.length[:, np.newaxis] * ahead, axis=0)])
    link = np.clip(np.searchsorted(np.cumsum(body.length), body.stations, side="right"), 0, len(body.length) - 1)
    along = body.stations - np.append(0.0, np.cumsum(body.length))[link]
    middle = joints[link] + along[:, np.newaxis] * ahead[link]
    side = np.sqrt(body.section[:, :1]) * ahead[link][:, ::-1] * [-1, 1]
    return np.vstack([middle + side, (middle - side)[::-1]])


def film(name, gait, seed):
    """Film a gait of the hidden fish."""
    swim, noise = ht.swim(hidden, gait), np.random.default_rng(seed)
    seconds = max(BEATS / gait.frequency, LENGTHS * robot.body.length / swim.speed)
    motion = swim.continued(int(np.ceil(seconds * gait.frequency)))
    times = np.arange(int(seconds * RATE)) / RATE
    clock = motion.time.values - motion.time.values[0]
    poses = [motion.x.values, motion.y.values, motion.heading.values, *motion.bend.values.T]
    path = np.column_stack([np.interp(times, clock, values) for values in poses])
    path[:, :2] += [-0.5 * robot.body.length, 0.0] - (
        path[0, :2] + path[-1, :2]
    ) / 2  # the nose swims through the middle
    with av.open(f"{name}.mp4", "w") as out:
        stream = out.add_stream("libx264", rate=RATE, options={"crf": "18"})
        stream.width, stream.height, stream.pix_fmt = camera.width, camera.height, "yuv420p"
        for row in path:
            fine = np.full((4 * camera.height, 4 * camera.width), 180, np.uint8)
            points = 4 * camera.pixels(outline(row[:3], row[3:]), DEPTH) + 1.5
            cv2.fillPoly(fine, [np.rint(16 * points).astype(np.int32)], 50, cv2.LINE_AA, shift=4)
            frame = cv2.resize(fine, (camera.width, camera.height), interpolation=cv2.INTER_AREA)
            frame = np.clip(frame + 2 * noise.standard_normal(frame.shape), 0, 255).astype(np.uint8)
            out.mux(stream.encode(av.VideoFrame.from_ndarray(frame, format="gray").reformat(format="yuv420p")))
        out.mux(stream.encode(None))
    return frame


# %% [markdown]
# Run by run: the design asks for a gait, the film of it is tracked, the file is fitted to all films, and the design
# learns the speed.

# %%
unseen = ht.Gait.from_degrees(frequency=2.0, amplitude=(6, 10, 14), phase=(0, 30, 60))
true, manifests, fish = ht.swim(hidden, unseen).speed, [], robot
with ht.TankDesign("tank.jsonl", robot, bounds={"frequency": (1.5, 4)}) as tank:
    while (asked := tank.ask()).half_width > 0.08:
        off = abs(ht.swim(fish, unseen).speed / true - 1)
        print(f"{len(manifests)} films; the unseen gait is within 5 %: {off < 0.05}")
        choice = asked.choices[0]
        film(choice.name, choice.run.gait, seed=len(manifests))
        run = track_film(robot, f"{choice.name}.mp4", camera, depth=DEPTH)
        write_film_run(run, robot, f"{choice.name}.toml", "a drawn film")
        manifests.append(f"{choice.name}.toml")
        fit = ht.identify(robot, ht.read_trials(manifests, robot), validate=0)
        fish = fit.robot
        speed = np.hypot(*np.polyfit(run.tracked.time, run.head[:, :2], 1)[0])
        tank.tell([ht.SteadyRun(choice.name, choice.run.gait, float(speed))])

off = abs(ht.swim(fish, unseen).speed / true - 1)
print(f"{len(manifests)} films; the unseen gait is within 5 %: {off < 0.05}")

# %% [markdown]
# The intervals of the fit should hold the factors that were hidden. Those of the drag along the body and of the head
# are wide: both slow the fish by the same power of its speed, and the films tell their sum.

# %%
for one in fit.parameters:
    key = one["name"].split(".")[-1].split("[")[0]
    if key in factors:
        print(f"{key}: the interval holds {factors[key]}: {bool(one['low'] < factors[key] < one['high'])}")
fit.plot()

# %%
asked.plot()
