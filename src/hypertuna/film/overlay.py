"""The film with the outline over it, for people to look at."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from hypertuna.film.run import FilmRun
from hypertuna.film.source import Gray
from hypertuna.film.states import OK
from hypertuna.io.files import replaced

LARGEST = 960  # px of the overlay's width
MOST = 3600  # frames: of longer films every second one, or fewer
GOOD, BAD = (90, 220, 90), (60, 60, 240)  # blue, green, red
BITS = 4_000_000  # per second


def drawn(run: FilmRun, number: int, frame: Gray, thickness: int = 1) -> Any:
    """Return a frame (height, width, 3) in blue, green, red, with the outline and the joints of the fish."""
    import cv2

    picture = cv2.cvtColor(frame, cv2.COLOR_GRAY2BGR)
    unknowns = run.tracked.unknowns[number]
    if np.isfinite(unknowns).all():
        color = GOOD if run.tracked.state[number] == OK else BAD
        whole = np.concatenate([unknowns, [run.tuning.size, run.tuning.girth, 0.0]])
        joints, _ = run.body.joints(whole)
        for points, closed in ((run.body.outline(whole), True), (joints, False)):
            pixels = run.view.camera.pixels(points, run.view.depth)
            cv2.polylines(picture, [np.rint(16 * pixels).astype(np.int32)], closed, color, thickness, cv2.LINE_AA, 4)
    return picture


def write_overlay(run: FilmRun, path: str | Path, progress: Callable[[int, int], None]) -> None:
    """Write the film with the outline, small: green where it is used, red where it is not."""
    import av
    import cv2

    film = run.view.film
    every = -(-len(film.time) // MOST)
    factor = min(1.0, LARGEST / film.width)
    size = (2 * round(film.width * factor / 2), 2 * round(film.height * factor / 2))
    with replaced(path) as file, av.open(str(file), "w", format="mp4") as out:
        stream: Any = out.add_stream("mpeg4", rate=max(round(film.rate / every), 1))
        stream.width, stream.height = size
        stream.pix_fmt, stream.bit_rate = "yuv420p", BITS
        for number, frame in film.frames():
            if number % every:
                continue
            picture = cv2.resize(drawn(run, number, frame), size, interpolation=cv2.INTER_AREA)
            out.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="bgr24")))
            progress(number + 1, len(film.time))
        out.mux(stream.encode(None))
