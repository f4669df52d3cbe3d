"""A lamp that blinks in a film, and the clock of a log."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from film.rendered import write_film
from film.small import ROBOT
from hypertuna.errors import InputError
from hypertuna.film.blinks import blinks_of, clock_between, lamp_of, read_blinks
from hypertuna.film.source import open_film

ON = np.array([0.31, 1.27, 2.96, 4.05])  # s, by the film
OFFSET, DRIFT = 12.345, 2e-4  # film = log (1 + drift) + offset


def lit(draw, t, exposure=0.25 / 60):
    """Part of the exposure that ends at t in which the lamp is on, for 0.2 s each time."""
    return sum(np.clip(min(t, at + 0.2) - max(t - exposure, at), 0, exposure) / exposure for at in ON)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A film with a lamp at 150, 20 and a dark thing that moves, and a log of it at 100 Hz."""
    place, draw = tmp_path_factory.mktemp("blinks"), np.random.default_rng(0)
    pictures = []
    for k in range(280):
        picture = 150 + draw.normal(0, 3, (90, 160))
        picture[40:60, (k // 2) % 140 : (k // 2) % 140 + 20] = 50
        picture[17:24, 147:154] += (250 - picture[17:24, 147:154]) * lit(draw, k / 60)
        pictures.append(np.clip(picture, 0, 255).astype(np.uint8))
    write_film(place / "lamp.mp4", pictures)
    clock = np.arange(-1300, -400) / 100
    on = np.array([any(at <= OFFSET + (1 + DRIFT) * t < at + 0.2 for at in ON) for t in clock])
    rows = "".join(f"{t:.3f},{int(now)}\n" for t, now in zip(clock, on, strict=True))
    (place / "log.csv").write_text("time_s,led\n" + rows)
    return place


def test_the_lamp_is_found_and_its_blinks(folder) -> None:
    film = open_film(folder / "lamp.mp4")
    lamp = lamp_of(film)
    assert lamp == pytest.approx((150, 20), abs=4)
    for where in (lamp, (150, 20)):
        np.testing.assert_allclose(blinks_of(film, where), ON, atol=1 / 60)


def test_offset_and_drift_are_those_of_the_clocks(folder) -> None:
    film = open_film(folder / "lamp.mp4")
    clock = clock_between(blinks_of(film, (150, 20)), read_blinks(folder / "log.csv", "led"), film.rate, "lamp.mp4")
    assert clock.blinks == 4
    assert clock.middle == pytest.approx(ON.mean() - OFFSET, abs=0.02)
    assert clock.offset == pytest.approx(OFFSET + DRIFT * clock.middle, abs=3 * clock.sd)
    assert abs(clock.drift - DRIFT) < 3 * clock.drift_sd
    assert clock.sd == pytest.approx(1 / 60 / 12**0.5 / 2)


def test_a_blink_that_one_has_not_seen_does_not_matter() -> None:
    clock = clock_between(ON[1:], np.delete(ON, 2) - 5.0, 60.0, "a.mp4")
    assert (clock.blinks, clock.offset) == (2, pytest.approx(5.0))


def test_drift_over_an_hour_is_found() -> None:
    log = np.array([1.0, 2.0, 4.0, 3598.0, 3599.5])
    clock = clock_between(3.0 + 1.00008 * log, log, 60.0, "a.mp4")
    assert clock.blinks == 5
    assert clock.drift == pytest.approx(8e-5, rel=1e-3)
    assert clock.drift_sd < 2e-6


def test_blinks_that_repeat_or_do_not_fit_are_refused(folder) -> None:
    with pytest.raises(InputError, match="one way"):
        clock_between(np.arange(4.0), np.arange(6.0), 60.0, "a.mp4")
    with pytest.raises(InputError, match="same in film and log"):
        clock_between(np.array([0.0, 1.1, 2.7, 5.0]), np.array([0.0, 0.43, 3.9, 9.1]), 60.0, "a.mp4")
    film = open_film(folder / "lamp.mp4")
    with pytest.raises(InputError, match="must blink"):
        blinks_of(film, (20, 80))
    with pytest.raises(InputError, match="in the picture"):
        blinks_of(film, (200, 20))
    with pytest.raises(InputError, match="blink: missing|blink"):
        read_blinks(folder / "log.csv")


def test_command(folder, tmp_path) -> None:
    program = [sys.executable, "-m", "hypertuna", "trials", "clock", str(folder / "lamp.mp4")]
    options = ["--log", str(folder / "log.csv"), "--column", "led", "-o", str(tmp_path / "blinks.csv")]
    ran = subprocess.run([*program, *options], capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
    assert "time_offset_s = 12.3" in ran.stdout
    assert "17 ms" in ran.stdout
    assert len((tmp_path / "blinks.csv").read_text().splitlines()) == 6
    page = (Path(ROBOT).parents[1] / "docs/film.md").read_text()
    own = next(line.split() for line in page.splitlines() if line.startswith("hypertuna trials clock"))
    assert own[3:] == ["run.mp4", *options[0:1], "log.csv", *options[2:5], "blinks.csv"]
    ran = subprocess.run([*program, *options, "--led", "150,20", "--json"], capture_output=True, text=True, check=False)
    assert json.loads(ran.stdout)["matched"] == 4
