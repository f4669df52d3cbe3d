"""Frames of a film as gray levels or colors, with their times, and the empty tank: the median over the film."""

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

Gray = NDArray[np.uint8]  # pixels of a picture

MAX_SAMPLES = 41  # frames spread over the film, from which the empty tank is found
SAMPLE_BYTES = 150_000_000  # memory for these frames [bytes]
MAX_PIXELS = 9_000_000  # largest number of pixels of a frame: 4K
RATES = (5.0, 2000.0)  # Hz: slowest and fastest frame rate
MAX_UNEVEN = 0.1  # largest deviation of a time step from a whole number of frame intervals [intervals]
MAX_LOST = 0.5  # largest fraction of time steps in which frames are missing
FILMED_AT = "com.android.capture.fps"  # where phones write the rate of slow motion
MIN_FRAMES, MAX_FRAMES = 24, 2_000_000  # of a film
# Formats that are read, by FFmpeg's name, with a test of the first bytes. Other formats may refer to further files.
FORMS: dict[str, Callable[[bytes], bool]] = {
    "mov": lambda head: head[4:8] in (b"ftyp", b"moov", b"mdat", b"wide", b"free", b"skip"),
    "matroska": lambda head: head[:4] == b"\x1a\x45\xdf\xa3",
    "avi": lambda head: head[:4] == b"RIFF" and head[8:12] == b"AVI ",
}


@dataclass(frozen=True)
class Film:
    """A film: its file, the size of its frames, and the time of each."""

    file: str
    width: int
    height: int
    time: Array  # (frames,) [s] from the first
    begin: float = 0.0  # s: time of the first frame by the file's clock
    pace: float = 1.0  # real seconds per second of the file: below 1 for slow motion
    turn: int = 0  # quarter turns, counter-clockwise, that bring the stored pictures upright

    @property
    def rate(self) -> float:
        """Frame rate [Hz] over the whole film, counting lost frames; single times may be rounded to milliseconds."""
        interval = np.diff(self.time)
        return float(np.rint(interval / np.median(interval)).sum() / (self.time[-1] - self.time[0]))

    def frames(self, first: int = 0) -> Iterator[tuple[int, Gray]]:
        """Yield the number and gray levels (height, width) of each frame, in order from frame `first`."""
        return self._decoded(first, self._gray)

    def colors(self, first: int = 0) -> Iterator[tuple[int, Gray]]:
        """Yield the number and blue, green, red (height, width, 3) of each frame, in order from frame `first`."""
        return self._decoded(first, self._color)

    def _decoded(self, first: int, picture: Callable[[Any], Gray]) -> Iterator[tuple[int, Gray]]:
        """Yield the number and picture of each frame, in order from frame `first`."""
        half_interval = 0.5 / self.rate
        with _decoder(self.file) as (container, stream):
            if first > 0:
                _seek(container, stream, self._stamp(first), self.file)
            for frame in _read(container.decode(stream), self.file):
                if frame.time is None or frame.is_corrupt:
                    continue
                number = int(np.searchsorted(self.time, (frame.time - self.begin) * self.pace - half_interval))
                if number >= first and number < len(self.time):
                    yield number, picture(frame)

    def _stamp(self, number: int) -> float:
        """Return the time [s] of a frame in the file's own clock, by its number."""
        return self.begin + float(self.time[number]) / self.pace

    def sample(self, count: int = MAX_SAMPLES, *, colors: bool = False) -> Gray:
        """Return gray levels (samples, height, width), or colors (..., 3), of frames spread over the film.

        They are key frames, found by seeking. If the film has too few key frames, it is read from begin to end.
        """
        pixels = self.width * self.height * (3 if colors else 1)
        count = max(5, min(count, SAMPLE_BYTES // pixels, len(self.time)))
        numbers = np.linspace(0, len(self.time) - 1, count).round().astype(int)
        pictures: dict[float, Gray] = {}
        picture = self._color if colors else self._gray
        with _decoder(self.file) as (container, stream):
            for number in numbers if len(self.time) > 4 * count else ():
                _seek(container, stream, self._stamp(number), self.file)
                frame = next(_read(container.decode(stream), self.file), None)
                if frame is not None and frame.time is not None and frame.time not in pictures:
                    pictures[frame.time] = picture(frame)
        if len(pictures) < 0.7 * count:
            pictures = {float(k): frame for k, frame in self._decoded(0, picture) if k in numbers}
        return np.stack([*pictures.values()])

    def _gray(self, frame: Any) -> Gray:
        """Return the gray levels of a frame."""
        if frame.format.name.startswith(("yuv", "gray", "nv12")) and frame.format.components[0].bits == 8:
            plane = frame.planes[0]
            rows = np.frombuffer(plane, np.uint8).reshape(-1, plane.line_size)
            return self._shown(rows[: frame.height, : frame.width])
        return self._shown(frame.to_ndarray(format="gray"))

    def _color(self, frame: Any) -> Gray:
        """Return the colors of a frame."""
        return self._shown(frame.to_ndarray(format="bgr24"))

    def _shown(self, picture: Gray) -> Gray:
        """Return a copy of a picture turned upright: phones store upright films on their side."""
        turned = np.rot90(picture, self.turn)
        if turned.shape[:2] != (self.height, self.width):
            raise InputError("must have frames of one size", file=self.file, fix="film each run by itself")
        return turned.copy()


def open_film(path: str | Path, frame_rate: float | None = None) -> Film:
    """Read the times of a film, without its pictures, and check that its rate is constant.

    frame_rate: at which it was filmed [Hz], if the file has another one (slow motion).
    """
    need("film", "av", "cv2", by="films")
    name = str(path)
    with _decoder(name) as (container, stream):
        width, height = stream.codec_context.width, stream.codec_context.height
        if not 0 < width * height <= MAX_PIXELS:
            value, fix = f"{width} x {height} pixels", "film or convert it at 1920 x 1080"
            raise InputError(
                f"must have frames of at most {MAX_PIXELS / 1e6:g} million pixels", file=name, value=value, fix=fix
            )
        stamps = []
        for packet in _read(container.demux(stream), name):
            if packet.pts is not None and packet.size and not packet.is_discard:
                stamps.append(float(packet.pts * packet.time_base))
            if len(stamps) > MAX_FRAMES:
                raise InputError(f"must have {MAX_FRAMES} frames at most", file=name, value="longer", fix="cut it")
        filmed_rate = frame_rate or _filmed_at(container)
    stored = np.sort(np.array(stamps))
    pace = 1.0
    if filmed_rate is not None and len(stored) > 1 and (interval := float(np.median(np.diff(stored)))) > 0:
        pace = 1 / (interval * filmed_rate)
    time = _checked((stored - stored[:1]) * pace, name)
    turn = _turn(name)
    return Film(name, *((height, width) if turn % 2 else (width, height)), time, float(stored[0]), pace, turn)


def _filmed_at(container: Any) -> float | None:
    """Return the frame rate [Hz] at which a phone says that it filmed slow motion."""
    try:
        rate = float(container.metadata.get(FILMED_AT, ""))
    except ValueError:
        return None
    return rate if RATES[0] <= rate <= RATES[1] else None


def _turn(name: str) -> int:
    """Return the quarter turns that bring a film's pictures upright; raise an error if pictures are interlaced."""
    with _decoder(name) as (container, stream):
        frame = next(_read(container.decode(stream), name), None)
    if frame is None:
        raise InputError("must have pictures that can be decoded", file=name, value="none", fix="copy it anew")
    if frame.interlaced_frame:
        fix = "film progressively (60p, not 60i), or convert it: ffmpeg -i FILM -vf bwdif film.mp4"
        raise InputError("must have whole frames", file=name, value="interlaced: two half pictures in each", fix=fix)
    return int(round(frame.rotation / 90) % 4)


def _checked(time: Array, name: str) -> Array:
    """Check that frames are enough, at a usual rate and evenly spaced except for lost ones; return their times [s]."""
    if len(time) < MIN_FRAMES:
        value, fix = f"{len(time)}", "film six beats"
        raise InputError(
            f"must have {MIN_FRAMES} frames with times at least", file=name, key="frames", value=value, fix=fix
        )
    interval = np.diff(time)
    usual = float(np.median(interval))
    fix = "film at a constant rate, or give the rate at which it was filmed by converting it: ffmpeg -vf fps=60"
    if not (usual > 0 and RATES[0] <= 1 / usual <= RATES[1]):
        value = f"{1 / usual:.4g} Hz" if usual > 0 else "none"
        rule = f"must have a rate of {RATES[0]:g} to {RATES[1]:g} frames per second"
        raise InputError(rule, file=name, key="times of frames", value=value, fix=fix)
    multiple = interval / usual
    steps = np.maximum(np.rint(multiple), 1)
    uneven = np.abs(multiple - steps) > MAX_UNEVEN + 0.0015 / usual  # times of some formats are whole milliseconds
    if uneven.any() or (steps > 1).mean() > MAX_LOST:
        worst = int(np.argmax(np.abs(multiple - steps)))
        value = f"variable: {1e3 * interval[worst]:.3g} ms after frame {worst}, {1e3 * usual:.3g} ms in general"
        raise InputError("must have a constant rate", file=name, key="times of frames", value=value, fix=fix)
    return time


def background_of(samples: Gray) -> Gray:
    """Return the median picture (height, width) of frames (samples, height, width), in stripes to save memory."""
    stripes = np.array_split(np.arange(samples.shape[1]), 16)
    parts = [np.median(samples[:, rows], axis=0) for rows in stripes if len(rows)]
    return np.concatenate(parts).astype(np.uint8)


@contextmanager
def _decoder(name: str) -> Iterator[tuple[Any, Any]]:
    """Open the first video stream of a file, and yield its PyAV container and stream."""
    import av

    with opened(name, "film") as stream:
        head = stream.read(16)
        form = next((form for form, matches in FORMS.items() if matches(head)), None)
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
    """Yield the packets or frames of a decoder; raise an InputError if the file is damaged."""
    import av

    try:
        yield from parts
    except (av.FFmpegError, ValueError) as error:
        raise _unreadable(name, error) from None


def _seek(container: Any, stream: Any, time: float, name: str) -> None:
    """Move a container to the last key frame before a time [s] in the file's own clock."""
    import av

    for place in (int(time / stream.time_base), stream.start_time or 0):
        try:
            container.seek(place, stream=stream, backward=True)
            return
        except av.FFmpegError as error:
            failed = error
    raise _unreadable(name, failed)


def _unreadable(name: str, error: Exception) -> InputError:
    """Return the error for a file that is damaged or no film."""
    text = type(error).__name__
    return InputError(
        "must be a whole film", file=name, value=f"not ({text})", fix="copy it anew, or convert it to MP4"
    )
