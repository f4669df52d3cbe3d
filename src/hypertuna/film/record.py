"""Record a live camera, a network camera or a pipe to a film file, with the times of its frames."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

from hypertuna.errors import InputError, shown
from hypertuna.io.extras import need
from hypertuna.io.files import replaced

CAMERA = "camera:"  # prefix of a local camera's number
# Prefixes of network addresses.
NETWORK = ("rtsp://", "http://", "https://", "udp://", "tcp://")
PROTOCOLS = "rtsp,rtp,udp,tcp,http,https,tls"  # without "file": a remote playlist must not open local files
PIPE = "-"  # name of the standard input
# per operating system: FFmpeg's input device, and how it names a camera of a given number
DEVICES = {"linux": ("v4l2", "/dev/video{}"), "darwin": ("avfoundation", "{}"), "win32": ("dshow", "video={}")}
COPIED_CODECS = ("h264", "hevc", "mjpeg", "vp8", "vp9", "av1", "mpeg4")  # written without encoding again
MAX_REORDER = 0.5  # s: a packet may arrive this much before one with an earlier time
TIMEOUT = 10.0  # s without a frame
QUALITY = 2  # quality of MPEG-4, 1 (best) to 31, for cameras that send raw pictures


def is_live(name: str) -> bool:
    """Return whether a name is a camera, a network address or the pipe, not a file."""
    return name == PIPE or name.lower().startswith((CAMERA, *NETWORK))


def record(
    source: str,
    path: str | Path,
    *,
    duration: float,
    size: tuple[int, int] | None = None,
    rate: float | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> int:
    """Record a source for a duration [s] into a film (Matroska); return the number of frames.

    Frames keep the times that the source gives them. size [px], rate [Hz]: requested from a camera.
    """
    need("film", "av", "cv2", by="cameras")
    import av

    count, first = 0, None
    try:
        with _source(source, size, rate) as container, replaced(path) as file:
            with av.open(str(file), "w", format="matroska") as out:
                for time_, write in _written(container, out):
                    first = time_ if first is None else first
                    if time_ - first > duration + MAX_REORDER:
                        break
                    if time_ - first > duration:
                        continue
                    write()
                    count += 1
                    progress(min(int(1e3 * (time_ - first)), int(1e3 * duration)), int(1e3 * duration))
            if not count:
                raise _nothing(source, "no pictures")
    except InputError:
        raise
    except (av.FFmpegError, ValueError, OSError) as error:
        raise _nothing(source, f"{type(error).__name__}") from None
    return count


def _nothing(source: str, value: str) -> InputError:
    """Return the error for a source that gives no frames; value: what the source gave instead."""
    fixes = {
        CAMERA: "connect it, check its number and whether another program uses it, or give its address",
        PIPE: "pipe a film into the command: it must be MP4, Matroska or MPEG-TS, and begin with its head",
    }
    fix = fixes.get(CAMERA if source.lower().startswith(CAMERA) else source, "check the address by opening it in VLC")
    return InputError("must give pictures", key=source, value=value, fix=fix)


@contextmanager
def _source(source: str, size: tuple[int, int] | None, rate: float | None) -> Iterator[Any]:
    """Open a camera, an address or the pipe, and yield its PyAV container."""
    import av

    settings = {"video_size": f"{size[0]}x{size[1]}"} if size is not None else {}
    settings |= {"framerate": f"{rate:g}"} if rate is not None else {}
    if source == PIPE:
        stream = av.open(sys.stdin.buffer, options={"protocol_whitelist": "pipe"}, timeout=TIMEOUT)
    elif source.lower().startswith(CAMERA):
        number = source[len(CAMERA) :]
        if not number.isdecimal():
            rule, fix = "must be a number", f"give {CAMERA}0 for the first one"
            raise InputError(rule, key=CAMERA, value=shown(number), fix=fix)
        device, name = DEVICES.get(sys.platform, DEVICES["linux"])
        if device not in {one for names in av.formats_available for one in names.split(",")}:
            fix = "record by its own program, and track the file"
            raise InputError("cannot be opened by this PyAV", key=source, value=f"without {device}", fix=fix)
        stream = av.open(name.format(number), format=device, options=settings, timeout=TIMEOUT)
    elif source.lower().startswith(NETWORK):
        stream = av.open(source, options={"protocol_whitelist": PROTOCOLS}, timeout=TIMEOUT)
    else:
        fix = f"give {CAMERA}0, an address ({', '.join(NETWORK)}) or {PIPE} for a pipe; films are tracked as they are"
        raise InputError("must be a camera", key=shown(source), fix=fix)
    with stream:
        if not stream.streams.video:
            raise _nothing(source, "only sound")
        yield stream


def _written(container: Any, out: Any) -> Iterator[tuple[float, Callable[[], None]]]:
    """Yield the time [s] of each frame and a function that writes it: packets unchanged, raw pictures as MPEG-4."""
    stream, begin = container.streams.video[0], time.monotonic()
    if stream.codec_context.name in COPIED_CODECS:
        copied = out.add_stream_from_template(stream)
        started = False
        for packet in container.demux(stream):
            if packet.pts is None or not packet.size or not (started := started or packet.is_keyframe):
                continue
            stamp = float(packet.pts * packet.time_base)
            packet.stream = copied
            yield stamp, partial(out.mux, packet)
        return
    encoded = out.add_stream("mpeg4", rate=1000)
    encoded.width, encoded.height, encoded.pix_fmt = stream.codec_context.width, stream.codec_context.height, "yuv420p"
    encoded.codec_context.flags |= 2  # AV_CODEC_FLAG_QSCALE
    encoded.codec_context.global_quality = 118 * QUALITY
    for frame in container.decode(stream):
        stamp = frame.time if frame.time is not None else time.monotonic() - begin
        yield stamp, partial(_encode, out, encoded, frame)
    out.mux(encoded.encode(None))


def _encode(out: Any, stream: Any, frame: Any) -> None:
    """Encode a raw picture with an output stream, and write it to the output file."""
    out.mux(stream.encode(frame.reformat(format="yuv420p")))
