"""A small fish, and small films of it with what they show."""

from pathlib import Path

import numpy as np

import hypertuna as ht
from film.rendered import Eye, Fish, Scene, frames, write_film
from hypertuna.film.camera import Camera
from hypertuna.film.sections import Body

ROBOT = str(Path(__file__).parents[2] / "examples/minnow.toml")
DEPTH = 0.08  # m


def fish():
    """The minnow, with sections of a plain spindle and a thin fin."""
    length = np.array(ht.load(ROBOT).links.length)
    s = np.linspace(0, 1, 301)
    width = 0.022 * np.sqrt(np.clip(1 - ((s - 0.3) / np.where(s < 0.3, 0.3, 0.62)) ** 2, 0, 1))
    width = np.where(s > 0.87, 0.0012, np.maximum(width, 0.0012 * (s > 0.1)))
    height = 0.034 * np.sqrt(np.clip(1 - ((s - 0.35) / np.where(s < 0.35, 0.35, 0.65)) ** 2, 0, 1))
    height = np.where(s > 0.8, np.maximum(height, 0.02 + 0.15 * (s - 0.8)), height)
    return Fish(length, np.tril(np.ones((4, 3)), -1), width, height)


def body(drawn):
    """The same for the tracker."""
    section = np.stack([drawn.half_width, drawn.half_height], axis=1) ** 2
    return Body(drawn.length, drawn.share, section, ("front", "middle", "fin"), measured=True)


def sections(drawn, path):
    """Write the sections of a fish as users do."""
    rows = zip(
        np.linspace(0, drawn.length.sum(), len(drawn.half_width)), 2 * drawn.half_width, 2 * drawn.half_height,
        strict=True,
    )  # fmt: skip
    lines = ["from_nose_m,width_m,height_m", *(f"{x:.8g},{w:.8g},{h:.8g}" for x, w, h in rows)]
    path.write_text("\n".join(lines) + "\n")
    return path


def camera(eye):
    """The camera of an eye that looks straight down."""
    assert eye.tilt == (0.0, 0.0)
    width, height = eye.size
    return Camera(
        width_px=width, height_px=height, focal_px=eye.focal, center_px=((width - 1) / 2, (height - 1) / 2),
        lens_k1=eye.k1, place_m=eye.place, refractive_index=eye.index,
    )  # fmt: skip


EYE = Eye(size=(480, 272), focal=640.0, k1=-0.1, place=(0.02, -0.01, 1.6))


def beating(t, speed=0.65, frequency=3.5):
    """A fish that swims to the left and beats: pose of the nose, joint angles."""
    phase = 2 * np.pi * frequency * t
    angle = np.radians([8, 14, 20]) * np.sin(phase - np.radians([0, 30, 60]))
    return np.array([0.27 - speed * t, 0.03 + 0.004 * np.sin(phase), 0.1 + np.radians(3) * np.sin(phase + 1)]), angle


def film(path, motion=beating, count=60, eye=EYE, rate=60, times=None, **scene):
    """Write a film and return the truth (frames, 6) of what it shows."""
    shown = np.arange(count) / rate
    setting = Scene(eye, fish(), depth=DEPTH, rate=rate, **scene)
    write_film(path, frames(setting, motion, shown), rate=rate, times=times)
    return np.array([np.concatenate(motion(t)) for t in shown])
