"""Draw the tracked outline over the film, for people to check."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from hypertuna.film.camera import Camera
from hypertuna.film.run import FilmRun
from hypertuna.film.source import Film, Gray
from hypertuna.film.states import OK
from hypertuna.io.files import replaced
from hypertuna.trials.marker_run import MarkerRun

MAX_WIDTH = 960  # px
MAX_FRAMES = 3600  # frames in the overlay; of longer films, only every second frame or fewer are written
GOOD, BAD = (90, 220, 90), (60, 60, 240)  # colors as (blue, green, red)
BIT_RATE = 4_000_000  # bits per second


def drawn(run: FilmRun, number: int, frame: Gray, thickness: int = 1) -> Any:
    """Return a frame as a picture (height, width, 3) in blue, green, red, with outline and joints of the fish."""
    import cv2

    picture = cv2.cvtColor(frame, cv2.COLOR_GRAY2BGR)
    unknowns = run.tracked.unknowns[number]
    if np.isfinite(unknowns).all():
        color = GOOD if run.tracked.state[number] == OK else BAD
        all_unknowns = np.concatenate([unknowns, [run.tuning.size, run.tuning.girth, 0.0]])
        joints, _ = run.body.joints(all_unknowns)
        for points, closed in ((run.body.outline(all_unknowns), True), (joints, False)):
            pixels = run.view.camera.pixels(points, run.view.depth)
            cv2.polylines(picture, [np.rint(16 * pixels).astype(np.int32)], closed, color, thickness, cv2.LINE_AA, 4)
    return picture


def marked(run: MarkerRun, film: Film, camera: Camera, depth: float) -> Callable[[int, Gray], Any]:
    """Return a function that draws a run's chain and marks over a frame: green ones are used, red ones are rejected."""
    import cv2

    frames = np.searchsorted(film.time, run.markers.time - 0.5 / film.rate)
    rows = {int(frame): row for row, frame in enumerate(frames)}
    chain = camera.pixels(run.joints(np.arange(len(frames))), depth)
    seen = run.markers.weight > 0
    places = camera.pixels(np.where(seen[..., np.newaxis], run.markers.place, 0.0), depth)

    def draw(number: int, frame: Gray) -> Any:
        picture = cv2.cvtColor(frame, cv2.COLOR_GRAY2BGR)
        if (row := rows.get(number)) is None:
            return picture
        color = GOOD if run.fit.determined[row] else BAD
        cv2.polylines(picture, [np.rint(16 * chain[row]).astype(np.int32)], False, color, 1, cv2.LINE_AA, 4)
        for mark in np.flatnonzero(seen[row]):
            center = np.rint(16 * places[row, mark]).astype(int).tolist()
            cv2.circle(picture, center, 16 * 5, BAD if run.fit.rejected[row, mark] else GOOD, 1, cv2.LINE_AA, 4)
        return picture

    return draw


def write_overlay(
    film: Film, draw: Callable[[int, Gray], Any], path: str | Path, progress: Callable[[int, int], None]
) -> None:
    """Write a small copy of a film with `draw` over its frames: green where the result is used, red where it is not."""
    import av
    import cv2

    every = -(-len(film.time) // MAX_FRAMES)
    factor = min(1.0, MAX_WIDTH / film.width)
    size = (2 * round(film.width * factor / 2), 2 * round(film.height * factor / 2))
    with replaced(path) as file, av.open(str(file), "w", format="mp4") as out:
        stream: Any = out.add_stream("mpeg4", rate=max(round(film.rate / every), 1))
        stream.width, stream.height = size
        stream.pix_fmt, stream.bit_rate = "yuv420p", BIT_RATE
        for number, frame in film.frames():
            if number % every:
                continue
            picture = cv2.resize(draw(number, frame), size, interpolation=cv2.INTER_AREA)
            out.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="bgr24")))
            progress(number + 1, len(film.time))
        out.mux(stream.encode(None))
