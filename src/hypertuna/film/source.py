"""Frames of a film as gray levels, with their times, and the empty tank: the median of frames all over the film."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hypertuna.arrays import Array
from hypertuna.errors import InputError
from hypertuna.io.door import opened
from hypertuna.io.extras import need

Gray = NDArray[np.uint8]

SAMPLES = 41  # frames of the median, all over the film
ROOM = 150_000_000  # bytes of these
LARGEST = 9_000_000  # pixels of a frame: 4K
RATES = (5.0, 2000.0)  # Hz
UNEVEN = 0.1  # of the interval: how far a time may lie from a multiple of it
LOST = 0.5  # of the intervals, by frames that are missing
LEAST, MOST = 24, 2_000_000  # frames
# The forms of films that are read, by the name of FFmpeg and their first bytes: others may name further files.
FORMS: dict[str, Callable[[bytes], bool]] = {
    "mov": lambda head: head[4:8] in (b"ftyp", b"moov", b"mdat", b"wide", b"free", b"skip"),
    "matroska": lambda head: head[:4] == b"\x1a\x45\xdf\xa3",
    "avi": lambda head: head[:4] == b"RIFF" and head[8:12] == b"AVI ",
}


@dataclass(frozen=True)
class Film:
    """A film: its file, the size of its frames, and the times of all of them."""

    file: str
    width: int
    height: int
    time: Array  # (frames,) [s] from the first

    @property
    def rate(self) -> float:
        """Frames per second [Hz]."""
        return 1 / float(np.median(np.diff(self.time)))

    def frames(self, first: int = 0) -> Iterator[tuple[int, Gray]]:
        """Yield number and gray levels (height, width) of frames in order, from a number on."""
        half = 0.5 / self.rate
        with _decoder(self.file) as (container, stream):
            if first > 0:
                _seek(container, stream, float(self.time[first]))
            begin = None if stream.start_time is None else float(stream.start_time * stream.time_base)
            for frame in _read(container.decode(stream), self.file):
                if frame.time is None or frame.is_corrupt:
                    continue
                begin = frame.time if begin is None else begin
                number = int(np.searchsorted(self.time, frame.time - begin - half))
                if number >= first and number < len(self.time):
                    yield number, self._gray(frame)

    def sample(self, count: int = SAMPLES) -> Gray:
        """Return gray levels (samples, height, width) of frames all over the film: its key frames, by seeking.

        A film that has too few of them is short, and read from its begin to its end.
        """
        count = max(5, min(count, ROOM // (self.width * self.height), len(self.time)))
        wanted = np.linspace(0, len(self.time) - 1, count).round().astype(int)
        found: dict[float, Gray] = {}
        with _decoder(self.file) as (container, stream):
            for number in wanted if len(self.time) > 4 * count else ():
                _seek(container, stream, float(self.time[number]))
                frame = next(_read(container.decode(stream), self.file), None)
                if frame is not None and frame.time is not None and frame.time not in found:
                    found[frame.time] = self._gray(frame)
        if len(found) < 0.7 * count:
            found = {float(k): frame for k, frame in self.frames() if k in wanted}
        return np.stack([*found.values()])

    def _gray(self, frame: Any) -> Gray:
        """Return the gray levels of a frame."""
        if (frame.width, frame.height) != (self.width, self.height):
            raise InputError("must have frames of one size", file=self.file, fix="film each run by itself")
        if frame.format.name.startswith(("yuv", "gray", "nv12")) and frame.format.components[0].bits == 8:
            plane = frame.planes[0]
            rows = np.frombuffer(plane, np.uint8).reshape(-1, plane.line_size)
            return rows[: self.height, : self.width].copy()
        return np.asarray(frame.to_ndarray(format="gray"))


def open_film(path: str | Path) -> Film:
    """Read the times of a film, without its pictures, and check that its rate is constant."""
    need("film", "av", "cv2", by="films")
    name = str(path)
    with _decoder(name) as (container, stream):
        width, height = stream.codec_context.width, stream.codec_context.height
        if not 0 < width * height <= LARGEST:
            value, fix = f"{width} x {height} pixels", "film or convert it at 1920 x 1080"
            raise InputError(
                f"must have frames of at most {LARGEST / 1e6:g} million pixels", file=name, value=value, fix=fix
            )
        stamps = []
        for packet in _read(container.demux(stream), name):
            if packet.pts is not None and packet.size:
                stamps.append(float(packet.pts * packet.time_base))
            if len(stamps) > MOST:
                raise InputError(f"must have {MOST} frames at most", file=name, value="longer", fix="cut it")
    time = np.sort(np.array(stamps))
    return Film(name, width, height, _checked(time - time[:1], name))


def _checked(time: Array, name: str) -> Array:
    """Check times: enough, of a usual rate, evenly spaced but for lost frames."""
    if len(time) < LEAST:
        value, fix = f"{len(time)}", "film six beats"
        raise InputError(f"must have {LEAST} frames with times at least", file=name, key="frames", value=value, fix=fix)
    interval = np.diff(time)
    usual = float(np.median(interval))
    fix = "film at a constant rate, or give the rate at which it was filmed by converting it: ffmpeg -vf fps=60"
    if not (usual > 0 and RATES[0] <= 1 / usual <= RATES[1]):
        value = f"{1 / usual:.4g} Hz" if usual > 0 else "none"
        rule = f"must have a rate of {RATES[0]:g} to {RATES[1]:g} frames per second"
        raise InputError(rule, file=name, key="times of frames", value=value, fix=fix)
    multiple = interval / usual
    steps = np.maximum(np.rint(multiple), 1)
    uneven = np.abs(multiple - steps) > UNEVEN + 0.0015 / usual  # times of some formats are whole milliseconds
    if uneven.any() or (steps > 1).mean() > LOST:
        worst = int(np.argmax(np.abs(multiple - steps)))
        value = f"variable: {1e3 * interval[worst]:.3g} ms after frame {worst}, {1e3 * usual:.3g} ms in general"
        raise InputError("must have a constant rate", file=name, key="times of frames", value=value, fix=fix)
    return time


def background_of(samples: Gray) -> Gray:
    """Return the median of frames (samples, height, width), a stripe at a time."""
    stripes = np.array_split(np.arange(samples.shape[1]), 16)
    parts = [np.median(samples[:, rows], axis=0) for rows in stripes if len(rows)]
    return np.concatenate(parts).astype(np.uint8)


@contextmanager
def _decoder(name: str) -> Iterator[tuple[Any, Any]]:
    """Open the first video of a file."""
    import av

    with opened(name, "film") as stream:
        head = stream.read(16)
        form = next((form for form, is_of in FORMS.items() if is_of(head)), None)
        if form is None:
            fix = "convert it: ffmpeg -i FILM film.mp4"
            raise InputError("must be a film: MP4, MOV, MKV, WebM or AVI", file=name, fix=fix)
        stream.seek(0)
        try:
            container = av.open(stream, format=form)
        except (av.FFmpegError, ValueError) as error:
            raise _unreadable(name, error) from None
        with container:
            if not container.streams.video:
                raise InputError("must hold moving pictures", file=name, fix="give the film, not its sound")
            video = container.streams.video[0]
            if video.codec_context is None:
                fix = "convert it: ffmpeg -i FILM -c:v libx264 film.mp4"
                raise InputError("must be of a known codec", file=name, value="of another", fix=fix)
            video.thread_type = "AUTO"
            video.codec_context.thread_count = min(4, os.cpu_count() or 1)
            yield container, video


def _read(parts: Iterator[Any], name: str) -> Iterator[Any]:
    """Yield what a decoder gives; damage is an error of the file."""
    import av

    try:
        yield from parts
    except (av.FFmpegError, ValueError) as error:
        raise _unreadable(name, error) from None


def _seek(container: Any, stream: Any, time: float) -> None:
    """Go to the last key frame before a time from the first frame [s]."""
    import av

    begin = stream.start_time or 0
    try:
        container.seek(begin + int(time / stream.time_base), stream=stream, backward=True)
    except av.FFmpegError:
        container.seek(begin, stream=stream, backward=True)


def _unreadable(name: str, error: Exception) -> InputError:
    """Return the error of a file that is no whole film."""
    text = type(error).__name__
    return InputError(
        "must be a whole film", file=name, value=f"not ({text})", fix="copy it anew, or convert it to MP4"
    )
