"""Films of a swimming chain, drawn by tracing rays: from pixels through the lens and the water to elliptical sections.

It shares no code with the tracker: a body is what a ray hits, section by section and height by height.
"""

from dataclasses import dataclass, field, replace
from fractions import Fraction

import av
import cv2
import numpy as np

FINE = np.array([[-3, -1], [1, -3], [3, 1], [-1, 3]]) / 8  # places in a pixel, a turned grid


@dataclass(frozen=True)
class Eye:
    """A camera over water whose surface is z = 0. Pixels count from the center of the first one."""

    size: tuple = (1280, 720)
    focal: float = 1100.0  # px
    k1: float = 0.0
    place: tuple = (0.0, 0.0, 1.6)  # m
    tilt: tuple = (0.0, 0.0)  # rad about the picture's x and y axes
    index: float = 1.333

    def rays(self, depth, shift=(0.0, 0.0)):
        """Points (h, w, 2) [m] at a depth that the pixels see, and the way that each ray goes aside per meter down."""
        width, height = self.size
        u, v = np.meshgrid(np.arange(width) + shift[0], np.arange(height) + shift[1])
        x, y = (u - (width - 1) / 2) / self.focal, (v - (height - 1) / 2) / self.focal
        far = np.hypot(x, y)
        r = far.copy()
        for _ in range(20):  # Newton on r + k1 r^3 = far
            r -= (r + self.k1 * r**3 - far) / (1 + 3 * self.k1 * r**2)
        factor = np.divide(r, far, out=np.ones_like(r), where=far > 0)
        ray = np.stack([x * factor, y * factor, np.ones_like(x)], axis=-1)
        a, b = self.tilt
        about_x = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
        about_y = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
        down = np.diag([1.0, -1.0, -1.0])  # picture's x right, y down, z ahead: x, y, z of the tank
        ray = ray @ (down @ about_x @ about_y).T
        ray /= np.linalg.norm(ray, axis=-1, keepdims=True)
        surface = np.array(self.place) + ray * (-self.place[2] / ray[..., 2])[..., np.newaxis]
        bent = ray[..., :2] / self.index  # Snell: the horizontal part of a unit ray shrinks by the index
        aside = bent / np.sqrt(1 - (bent**2).sum(axis=-1))[..., np.newaxis]
        return surface[..., :2] + depth * aside, aside


@dataclass(frozen=True)
class Fish:
    """Links [m], how joint angles turn them, half widths and half heights [m] of stations from nose to tail."""

    length: np.ndarray
    share: np.ndarray  # (links, groups)
    half_width: np.ndarray
    half_height: np.ndarray

    def cover(self, point, aside, pose, angle, pixel):
        """Part of each pixel (n,) that the body takes: points [m], pose of the nose, joint angles [rad]."""
        heading = pose[2] + self.share @ angle
        total, stations = self.length.sum(), np.linspace(0, 1, len(self.half_width))
        start, begin, best = np.array(pose[:2]), 0.0, np.full(len(point), -np.inf)
        levels, widest = np.sin(np.linspace(-1.3, 1.3, 7)), self.half_width.max()
        for i, (long, turn) in enumerate(zip(self.length, heading, strict=True)):
            e, n = np.array([np.cos(turn), np.sin(turn)]), np.array([-np.sin(turn), np.cos(turn)])
            along, across, lean = (point - start) @ e, (point - start) @ n, aside @ n
            # no ray elsewhere meets this link
            reach = pixel + widest + self.half_height.max() * np.abs(lean).max(initial=0)
            near = np.flatnonzero((np.abs(across) < reach) & (-reach < along) & (along < long + reach))
            along, across, lean = along[near], across[near], lean[near]
            at = np.clip(along, 0, long)
            over = along - at
            wide = np.interp((begin + at) / total, stations, self.half_width)
            high = np.interp((begin + at) / total, stations, self.half_height)
            last = i == len(self.length) - 1
            ends = ((i == 0) & (along < 0)) | (last & (along > long))  # where a plane cuts the body off
            gone = np.where(ends, 0.0, over)
            for level in levels:  # the ray is elsewhere at each height of the section
                side = np.abs(across - level * high * lean)
                inside = wide * np.sqrt(1 - level**2) - np.hypot(side, gone)
                best[near] = np.maximum(best[near], np.where(ends, np.minimum(inside, -np.abs(over)), inside))
            start, begin = start + long * e, begin + long
        return np.clip(0.5 + best / pixel, 0, 1)


@dataclass(frozen=True)
class Scene:
    """What is filmed, and how."""

    eye: Eye
    fish: Fish
    depth: float = 0.08  # m of the fish
    floor: float = 0.6  # m deep
    rate: float = 60.0  # frames per second
    exposure: float = 0.25  # of the interval
    ripple: float = 0.0  # px rms of each component
    caustics: float = 0.0  # of the light
    noise: float = 3.0  # gray levels
    bright: float = 180.0  # gray level of the floor
    dark: float = 50.0  # of the fish
    cable: bool = False
    seed: int = 0
    extra: tuple = field(default=())  # (pose of the nose, angles) of other fish, at rest


def frames(scene, motion, times):
    """Yield gray frames (h, w) of uint8; `motion(t)` gives the pose of the nose and the joint angles."""
    draw = np.random.default_rng(scene.seed)
    width, height = scene.eye.size
    floor, _ = scene.eye.rays(scene.floor)
    line = np.minimum(*(np.abs((floor[..., k] / 0.1) % 1 - 0.5) for k in range(2)))
    paper = (
        scene.bright - 14 * np.exp(-((line / 0.03) ** 2)) + 6 * np.sin(7 * floor[..., 0]) * np.cos(5 * floor[..., 1])
    )
    here, aside = zip(*(scene.eye.rays(scene.depth, shift) for shift in FINE), strict=True)
    middle, _ = scene.eye.rays(scene.depth)
    pixel = float(np.abs(np.diff(middle[height // 2 - 1 : height // 2 + 1, width // 2], axis=0)).max())
    waves = _waves(draw, 48)
    flicker = _waves(draw, 24)
    coarse = np.stack(np.meshgrid(np.linspace(0, width, 40), np.linspace(0, height, 24)), axis=-1) * pixel
    u, v = np.meshgrid(np.arange(width, dtype=np.float32), np.arange(height, dtype=np.float32))
    for t in times:
        shift = np.zeros((height, width, 2), np.float32)
        if scene.ripple:
            field_ = _field(waves, coarse, t) * scene.ripple
            shift = cv2.resize(field_.astype(np.float32), (width, height), interpolation=cv2.INTER_CUBIC)
        picture = cv2.remap(paper.astype(np.float32), u + shift[..., 0], v + shift[..., 1], cv2.INTER_LINEAR,
                            borderMode=cv2.BORDER_REPLICATE)  # fmt: skip
        light = np.float32(1.0)
        if scene.caustics:
            small = _field(flicker, coarse * 3, 2 * t)[..., 0]
            light = 1 + scene.caustics * cv2.resize(small.astype(np.float32), (width, height))
        cover = np.zeros((height, width), np.float32)
        parts = np.linspace(-0.5, 0.5, len(FINE) + 1)[1:] - 0.5 / len(FINE)
        for k, part in enumerate(parts):
            bodies = [motion(t + part * scene.exposure / scene.rate), *scene.extra]
            for pose, angle in bodies:
                box = _box(middle, scene.fish, pose, angle, pixel)
                moved = here[k][box] + shift[box] * np.array([pixel, -pixel])
                flat = scene.fish.cover(moved.reshape(-1, 2), aside[k][box].reshape(-1, 2), pose, angle, pixel / 2)
                cover[box] = np.maximum(cover[box], 0) + flat.reshape(moved.shape[:2]) / len(parts)
        picture = (picture * (1 - cover) + scene.dark * cover) * light
        if scene.cable:
            pole = np.abs(v - 0.3 * u - 0.25 * height - 20 * np.sin(2 * t)) < 2.0
            picture = np.where(pole, 40, picture)
        picture = picture + scene.noise * draw.standard_normal(picture.shape, dtype=np.float32)
        yield np.clip(np.rint(picture), 0, 255).astype(np.uint8)


def _box(place, fish, pose, angle, pixel):
    """Rows and columns that a body may take."""
    heading = pose[2] + fish.share @ angle
    steps = fish.length[:, np.newaxis] * np.stack([np.cos(heading), np.sin(heading)], axis=1)
    joints = np.array(pose[:2]) + np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
    room = fish.half_width.max() + 14 * pixel
    low, high = joints.min(axis=0) - room, joints.max(axis=0) + room
    few = place[::8, ::8]
    near = (few > low).all(axis=-1) & (few < high).all(axis=-1)
    rows, columns = 8 * np.flatnonzero(near.any(axis=1)), 8 * np.flatnonzero(near.any(axis=0))
    if not len(rows):
        return (slice(0, 0), slice(0, 0))
    return (slice(max(rows[0] - 8, 0), rows[-1] + 9), slice(max(columns[0] - 8, 0), columns[-1] + 9))


def _waves(draw, count):
    """Directions and wave numbers [rad/m], rates [rad/s], phases, and directions of the shift."""
    turn, long = draw.uniform(0, 2 * np.pi, count), draw.uniform(0.12, 0.5, count)
    k = 2 * np.pi / long[:, np.newaxis] * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    rate = 2 * np.pi * draw.uniform(0.5, 2.5, count)
    return k, rate, draw.uniform(0, 2 * np.pi, (count, 2))


def _field(waves, place, t):
    """Shift (h, w, 2) of unit variance."""
    k, rate, phase = waves
    angle = place @ k.T + rate * t
    return np.stack([np.sqrt(2 / len(rate)) * np.sin(angle + phase[:, i]).sum(axis=-1) for i in range(2)], axis=-1)


def write_film(path, pictures, rate=60, times=None, crf=18):
    """Write gray frames as H.264; `times` [s] makes the rate variable."""
    with av.open(str(path), "w") as out:
        stream = None
        for k, picture in enumerate(pictures):
            if stream is None:
                stream = out.add_stream("libx264", rate=rate, options={"crf": str(crf), "preset": "veryfast"})
                stream.height, stream.width = picture.shape
                stream.pix_fmt = "yuv420p"
                if times is not None:
                    stream.codec_context.time_base = stream.time_base = Fraction(1, 90000)
            frame = av.VideoFrame.from_ndarray(picture, format="gray").reformat(format="yuv420p")
            if times is not None:
                frame.pts, frame.time_base = round(times[k] * 90000), stream.codec_context.time_base
            out.mux(stream.encode(frame))
        if stream is not None:
            out.mux(stream.encode(None))


def swim_motion(swim):
    """Motion of a settled swim: a function of time that gives the pose of the nose and the angles of all groups."""
    whole = swim.trajectory
    motion = whole.isel(time=slice(-swim.steps - 1, None))
    period = 1 / swim.gait.frequency
    begin = float(motion.time[0])
    phase = (motion.time.values - begin) / period
    place, heading = motion.x.values + 1j * motion.y.values, motion.heading.values
    turn, bend = heading[-1] - heading[0], motion.bend.values
    step = (place[-1] - place[0]) * np.exp(-1j * heading[0])

    def at(t):
        beat, part = divmod(t / period, 1.0)
        beat = int(beat)
        base, faced = place[0], turn * beat  # after whole beats
        if abs(turn) > 1e-9:
            base = base + step * np.exp(1j * heading[0]) * (1 - np.exp(1j * faced)) / (1 - np.exp(1j * turn))
        else:
            base = base + step * np.exp(1j * heading[0]) * beat
        now = np.interp(part, phase, place.real) + 1j * np.interp(part, phase, place.imag)
        now = base + (now - place[0]) * np.exp(1j * faced)
        angle = np.array([np.interp(part, phase, bend[:, g]) for g in range(bend.shape[1])])
        return np.array([now.real, now.imag, np.interp(part, phase, heading) + faced]), angle

    return at


def moved(motion, offset, turn):
    """The same motion, turned about the origin and shifted."""

    def at(t):
        pose, angle = motion(t)
        place = (pose[0] + 1j * pose[1]) * np.exp(1j * turn) + complex(*offset)
        return np.array([place.real, place.imag, pose[2] + turn]), angle

    return at


def scene_of(fish, eye=None, **options):
    """A scene with usual values."""
    return replace(Scene(eye or Eye(), fish), **options)
