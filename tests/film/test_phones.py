"""Films as phones and cameras write them: turned, of ten bits, trimmed, slow, interlaced."""

from fractions import Fraction

import av
import numpy as np
import pytest

from film.rendered import write_film
from hypertuna.errors import InputError
from hypertuna.film.pace import check_made
from hypertuna.film.source import open_film

COUNT = 60


def picture(k):
    """A bar that moves over a gray ramp: no symmetry."""
    shown = np.tile(np.linspace(120, 200, 96), (64, 1))
    shown[10:18, k : k + 20] = 50
    return shown.astype(np.uint8)


def write(path, codec="libx265", pix_fmt="yuv420p", rate=60, first=0, turn=None, options=(), metadata=(), container=()):
    with av.open(str(path), "w", options=dict(container)) as out:
        out.metadata.update(dict(metadata))
        stream = out.add_stream(codec, rate=rate, options={"crf": "12", **dict(options)})
        stream.width, stream.height, stream.pix_fmt = 96, 64, pix_fmt
        if codec == "libx265":
            stream.options = {**stream.options, "x265-params": "log-level=none"}
        if turn is not None:
            stream.set_display_rotation(turn)
        for k in range(COUNT):
            frame = av.VideoFrame.from_ndarray(picture(k), format="gray").reformat(format=pix_fmt)
            frame.pts, frame.time_base = k + first, Fraction(1, rate)
            out.mux(stream.encode(frame))
        out.mux(stream.encode(None))


@pytest.mark.parametrize("turn", [0, 90, 180, 270])
def test_portraits_are_read_as_they_are_shown(tmp_path, turn) -> None:
    write(tmp_path / "phone.mov", turn=turn)
    film = open_film(tmp_path / "phone.mov")
    for k, shown in film.frames(20):
        truth = np.rot90(picture(k), turn // 90)
        assert (film.height, film.width) == truth.shape
        assert np.abs(shown.astype(int) - (16 + truth * (219 / 255))).max() < 12
    colors = next(film.colors(30))
    assert colors[0] == 30
    assert np.abs(colors[1].mean(axis=-1) - np.rot90(picture(30), turn // 90)).max() < 14


def test_ten_bits_are_read(tmp_path) -> None:
    write(tmp_path / "hdr.mov", pix_fmt="yuv420p10le")
    film = open_film(tmp_path / "hdr.mov")
    for k, shown in film.frames():
        assert np.abs(shown.astype(int) - picture(k)).max() < 14


def test_interlaced_pictures_are_refused(tmp_path) -> None:
    write(tmp_path / "fields.mp4", codec="libx264", options={"x264-params": "interlaced=1"})
    with pytest.raises(InputError, match="interlaced"):
        open_film(tmp_path / "fields.mp4")


@pytest.mark.parametrize("codec", ["libx264", "libx265"])
def test_a_trimmed_film_begins_where_it_is_shown(tmp_path, codec) -> None:
    """Phones cut films by a list of edits: frames before are in the file, and have no place in time."""
    write(tmp_path / "cut.mp4", codec=codec, first=-10, container={"avoid_negative_ts": "disabled"})
    film = open_film(tmp_path / "cut.mp4")
    assert len(film.time) == COUNT - 10
    numbers = []
    for k, shown in film.frames():
        numbers.append(k)
        assert np.abs(shown.astype(int) - (16 + picture(k + 10) * (219 / 255))).max() < 12
    assert numbers == [*range(COUNT - 10)]
    assert next(film.frames(40))[0] == 40


def test_slow_motion_has_the_rate_of_filming(tmp_path) -> None:
    tag = {"com.android.capture.fps": "240.000000"}
    write(tmp_path / "slow.mp4", rate=30, metadata=tag, container={"movflags": "use_metadata_tags"})
    write(tmp_path / "unknown.mp4", rate=30)
    for film in (open_film(tmp_path / "slow.mp4"), open_film(tmp_path / "unknown.mp4", 240.0)):
        assert film.rate == pytest.approx(240)
        assert [k for k, _ in film.frames()] == [*range(COUNT)]
        assert next(film.frames(37))[0] == 37
        assert film.sample(5).shape == (5, 64, 96)
    assert open_film(tmp_path / "unknown.mp4").rate == pytest.approx(30)


def test_frames_of_more_than_4k_are_refused(tmp_path) -> None:
    write_film(tmp_path / "large.mp4", (np.full((2988, 5312), 180, np.uint8) for _ in range(3)))
    with pytest.raises(InputError, match="9 million pixels"):
        open_film(tmp_path / "large.mp4")


def blob(k):
    """A dark blob that swims over a gray ramp."""
    y, x = np.mgrid[:64, :96]
    far = (x - 10 - 1.2 * k) ** 2 + (y - 32 - 12 * np.sin(0.4 * k)) ** 2
    return (np.tile(np.linspace(120, 200, 96), (64, 1)) - 90 * np.exp(-far / 40)).astype(np.uint8)


@pytest.mark.parametrize(
    ("made", "sentence"),
    [
        (lambda k: blob(k), ""),
        (lambda k: blob(k // 2 * 2), "50 % that repeat others: was the frame rate raised. .* -vf fps=30 film.mp4"),
        (lambda k: blob(k // 3 * 3), "67 % that repeat others: was the frame rate raised. .* -vf fps=20 film.mp4"),
        (lambda k: blob(k * 24 // 60 * 60 // 24), "60 % that repeat others: was the frame rate .* -vf fps=24 film.mp4"),
        (lambda k: blob(k - k % 2) // 2 + blob(k + k % 2) // 2, "50 % that lie between others: .* -vf fps=30 film"),
    ],
)
def test_frames_that_the_camera_did_not_film_are_named(tmp_path, made, sentence) -> None:
    """A film at 60, 30, 20 and 24 frames per second, repeated; and every second frame the mean of two."""
    write_film(tmp_path / "made.mp4", map(made, range(COUNT)), crf=4)
    film = open_film(tmp_path / "made.mp4")
    if not sentence:
        check_made(film)
        return
    with pytest.raises(InputError, match=f"must have frames that were filmed, but is with {sentence}"):
        check_made(film)
