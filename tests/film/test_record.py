"""Live sources, of which a film of known frames takes the place: by a pipe, and by the network."""

import io
import subprocess
import sys
import threading
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer

import av
import numpy as np
import pytest

from film.rendered import write_film
from hypertuna.errors import InputError
from hypertuna.film import record
from hypertuna.film.source import open_film


def pictures(count=90):
    for k in range(count):
        picture = np.full((48, 64), 180, np.uint8)
        picture[20:28, k % 40 : k % 40 + 16] = 40
        yield picture


@pytest.fixture(scope="module")
def film(tmp_path_factory):
    path = tmp_path_factory.mktemp("live") / "camera.mkv"
    write_film(path, pictures())
    return path


class Pipe(io.RawIOBase):
    """Bytes that cannot be sought, as those of a pipe."""

    def __init__(self, content):
        self.content = io.BytesIO(content)

    def readable(self):
        return True

    def read(self, size=-1):
        return self.content.read(size)


def piped(monkeypatch, content):
    class Input:
        buffer = Pipe(content)

    monkeypatch.setattr(record.sys, "stdin", Input)


def test_a_pipe_is_recorded_with_its_times(film, tmp_path, monkeypatch) -> None:
    piped(monkeypatch, film.read_bytes())
    assert record.record("-", tmp_path / "run.mkv", duration=1.0) == 61
    made, source = open_film(tmp_path / "run.mkv"), open_film(film)
    np.testing.assert_allclose(made.time, source.time[:61], atol=1e-3)
    for (_, one), (_, other) in zip(made.frames(), source.frames(), strict=False):
        np.testing.assert_array_equal(one, other)  # packets as they come


def test_raw_pictures_are_compressed(tmp_path, monkeypatch) -> None:
    stream = io.BytesIO()
    with av.open(stream, "w", format="matroska") as out:
        video = out.add_stream("rawvideo", rate=60)
        video.width, video.height, video.pix_fmt = 64, 48, "yuyv422"
        for picture in pictures(30):
            out.mux(video.encode(av.VideoFrame.from_ndarray(picture, format="gray").reformat(format="yuyv422")))
        out.mux(video.encode(None))
    piped(monkeypatch, stream.getvalue())
    assert record.record("-", tmp_path / "run.mkv", duration=9.0) == 30
    made = open_film(tmp_path / "run.mkv")
    np.testing.assert_allclose(made.time, np.arange(30) / 60, atol=1e-3)
    for (_, one), other in zip(made.frames(), pictures(30), strict=True):
        assert np.abs(one.astype(int) - other).mean() < 12  # 16 to 235 are black and white here


def test_an_address_is_recorded(film, tmp_path) -> None:
    class Quiet(SimpleHTTPRequestHandler):
        def log_message(self, *_):
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(film.parent)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        address = f"http://127.0.0.1:{server.server_port}/{film.name}"
        assert record.record(address, tmp_path / "run.mkv", duration=0.5) == 31
        with pytest.raises(InputError, match="must give pictures"):
            record.record(f"{address}.gone", tmp_path / "run.mkv", duration=0.5)
    finally:
        server.shutdown()
        server.server_close()


def test_a_playlist_names_no_files_here(film, tmp_path, monkeypatch) -> None:
    """A pipe may hold the list of a stream's parts; parts on this machine are not read."""
    piped(monkeypatch, f"#EXTM3U\n#EXT-X-TARGETDURATION:9\n#EXTINF:9,\n{film}\n#EXT-X-ENDLIST\n".encode())
    with pytest.raises(InputError, match="must give pictures"):
        record.record("-", tmp_path / "run.mkv", duration=0.5)
    assert not (tmp_path / "run.mkv").exists()


@pytest.mark.parametrize(
    ("source", "sentence"),
    [
        ("camera:7", "must give pictures|cannot be opened"),
        ("camera:front", "camera:0"),
        ("run.mp4", "must be a camera"),
    ],
)
def test_no_camera_is_a_sentence(tmp_path, source, sentence) -> None:
    with pytest.raises(InputError, match=sentence):
        record.record(source, tmp_path / "run.mkv", duration=1.0)


def test_commands(film, tmp_path) -> None:
    program = [sys.executable, "-m", "hypertuna", "trials"]
    own = [*program, "record", "-", "--duration", "1", "-o", str(tmp_path / "run.mkv")]
    ran = subprocess.run(own, input=film.read_bytes(), capture_output=True, check=False)
    assert ran.returncode == 0, ran.stderr
    assert b"61 frames of 64 x 48 pixels at 60 Hz" in ran.stdout
    own = [*program, "record", "camera:7", "--duration", "1", "-o", str(tmp_path / "no.mkv")]
    ran = subprocess.run(own, capture_output=True, text=True, check=False)
    assert ran.returncode == 2
    assert "camera:7 must give pictures" in ran.stderr
    own = [*program, "track", "camera:0", "-o", str(tmp_path / "run.toml")]
    ran = subprocess.run(own, capture_output=True, text=True, check=False)
    assert ran.returncode == 2
    assert "trials record camera:0" in ran.stderr
