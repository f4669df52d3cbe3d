"""Numbers of runs that contradict each other give a warning: each file of the tank with one column in another unit."""

import csv
import math
from pathlib import Path

import pytest

import hypertuna as ht
from hypertuna.trials.trials import implausible

TANK = Path(__file__).parents[2] / "examples" / "tank"
FISH = ht.load("hypertuna")


def warnings(folder: Path, name: str, column: str, change) -> str:
    """Return the warnings on a file of the tank whose column was changed."""
    head, *rows = csv.reader(line for line in (TANK / f"{name}.csv").read_text().splitlines() if line[0] != "#")
    k = head.index(column)
    for row in rows:
        row[k] = f"{change(float(row[k])):.6g}" if row[k] else ""
    path = folder / f"{name}.csv"
    path.write_text("\n".join(map(",".join, [head, *rows])))
    errors, texts = implausible(ht.read_trials([path], FISH), FISH)
    return " ".join(map(str, [*errors, *texts]))


@pytest.mark.parametrize(
    ("name", "column", "change", "sentence"),
    [
        (
            "tow",
            "drag_n",
            lambda drag: drag + 0.5,
            "grows as the power 0.9 of the speed, where drag grows by about its",
        ),
        (
            "tow",
            "drag_sd_n",
            lambda sd: 2.0,
            "the standard deviations exceed the values in all rows: are they in percent",
        ),
        ("thrust", "frequency_hz", lambda f: 2 * math.pi * f, "is 18.8 Hz, and the robot's gaits go to 6 Hz"),
        ("tank", "frequency_hz", lambda f: 60 * f, "the largest frequency is 360 Hz, and the robot's gaits go to 6 Hz"),
        (
            "tank",
            "amplitude_II_deg",
            math.radians,
            "the values of amplitude_II_deg are 0.44 deg at most: are they in rad",
        ),
        ("tank", "phase_II_deg", math.radians, "the values of phase_II_deg are 0.7 deg at most: are they in radians?"),
        ("tank", "speed_m_s", lambda speed: -speed, "the measured speeds have the other sign than those of the model"),
        ("tank", "cost_of_transport_j_per_kg_m", lambda cost: cost / 1000, "costs of transport are 0.001 times those"),
    ],
)
def test_a_column_in_another_unit_is_told(name, column, change, sentence, tmp_path) -> None:
    assert warnings(tmp_path, name, column, lambda value: value) == ""
    assert sentence in warnings(tmp_path, name, column, change)


def test_a_glide_that_ends_at_a_wall_is_told(tmp_path) -> None:
    rows = (TANK / "glide.csv").read_text() + "3.1,0.0,0.004\n3.2,0.0,0.004\n"
    (tmp_path / "glide.csv").write_text(rows)
    trials = ht.read_trials([tmp_path / "glide.csv"], FISH)
    assert "run glide stops at once at 3.1 s: did it touch a wall" in " ".join(implausible(trials, FISH)[1])
