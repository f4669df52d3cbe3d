"""Turns: the circle fit, the radius against the core's, the tightest phase, and the command."""

from __future__ import annotations

import json
import math
import runpy
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

import hypertuna as ht
from hypertuna.cli.main import main
from hypertuna.swimming.gait import named_gait
from hypertuna.swimming.plots_turn import plot_turn
from hypertuna.swimming.trajectory import center_of
from hypertuna.swimming.turn import Turning, fit_circle, nose_path, point_radius, tightest, turn

Run = Callable[..., tuple[int, str, str]]
PHASES = np.radians([160, 200, 240])


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """Run `hypertuna` with arguments: exit code, output, errors."""
    monkeypatch.setenv("COLUMNS", "200")

    def call(*arguments: str) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["hypertuna", *arguments])
        with pytest.raises(SystemExit) as exit_:
            main()
        return int(exit_.value.code or 0), *capsys.readouterr()

    return call


@pytest.fixture(scope="module")
def turning(tuna: ht.Robot) -> Turning:
    gait = named_gait(tuna, "turning")
    phases = [(0.0, phase) for phase in PHASES]
    return turn(tuna, ht.Gaits.grid(frequency=[2.0], amplitude=[gait.amplitude], phase=phases, bias=[gait.bias]))


# --- the circle


@given(
    x=st.floats(-10, 10), y=st.floats(-10, 10), radius=st.floats(0.01, 100), start=st.floats(0, 6), arc=st.floats(1, 6)
)
def test_points_of_a_circle_give_it_back(x: float, y: float, radius: float, start: float, arc: float) -> None:
    points = complex(x, y) + radius * np.exp(1j * np.linspace(start, start + arc, 25))
    circle = fit_circle(points)
    assert circle.radius == pytest.approx(radius, rel=1e-6)
    assert abs(circle.center - complex(x, y)) < 1e-6 * radius
    assert circle.residual < 1e-6 * radius


def test_noise_leaves_the_circle_where_it_is_and_is_the_residual() -> None:
    """1000 points, noise of 1 % of the radius across: the center is known to 0.01 sqrt(2 / 1000) = 4.5e-4."""
    random = np.random.default_rng(1)
    spokes = np.exp(1j * random.uniform(0, 2 * np.pi, 1000))
    circle = fit_circle(3 - 2j + spokes * (1 + 0.01 * random.standard_normal(1000)))
    assert circle.radius == pytest.approx(1, abs=3 * 0.01 / math.sqrt(1000))
    assert abs(circle.center - (3 - 2j)) < 3 * 4.5e-4
    assert circle.residual == pytest.approx(0.01, rel=0.1)


def test_the_distances_are_least_in_every_direction() -> None:
    random = np.random.default_rng(2)
    points = np.exp(1j * np.linspace(0, 2, 40)) * (1 + 0.1 * random.standard_normal(40))
    circle = fit_circle(points)

    def cost(shift: complex, wider: float) -> float:
        return float(np.sum((np.abs(points - circle.center - shift) - circle.radius - wider) ** 2))

    for shift, wider in ((1e-3, 0), (-1e-3, 0), (1e-3j, 0), (-1e-3j, 0), (0, 1e-3), (0, -1e-3)):
        assert cost(shift, wider) > cost(0, 0)


def test_a_beat_turns_about_the_center_of_its_ends() -> None:
    """A nose that ends where a turn about 3 + 4i takes its start; between, the beat swings it off the circle."""
    angle = np.array([0.3, 0.5, 0.6, 0.9])
    nose = 3 + 4j + np.array([2, 2.2, 1.7, 2]) * np.exp(1j * angle)
    heading = 1 + angle + [0, 0.2, -0.1, 0]
    parts = {"x": nose.real, "y": nose.imag, "heading": heading}
    motion = xr.Dataset({name: ("time", values) for name, values in parts.items()})
    assert center_of(motion) == pytest.approx(3 + 4j)


def test_points_on_a_line_have_no_circle() -> None:
    circle = fit_circle(np.linspace(0, 1, 9) * (1 + 2j))
    assert circle.radius == math.inf
    assert circle.residual < 1e-12
    assert fit_circle(np.ones(4, complex)).radius == 0


@pytest.mark.parametrize("points", [np.array([1 + 0j, 2]), np.array([0, 1, math.nan + 0j])])
def test_what_is_no_path_is_told(points: np.ndarray) -> None:
    with pytest.raises(ht.InputError, match="must be at least three finite points"):
        fit_circle(points)


# --- the turns


def test_the_circle_of_the_path_is_the_radius_of_the_core(turning: Turning) -> None:
    """The core takes the mean distance from the center from one beat; the fit knows nothing of center and beat."""
    np.testing.assert_allclose(turning.sweep.circle_radius, turning.sweep.turn_radius, rtol=1e-6)
    assert (turning.sweep.circle_residual < 0.02 * turning.robot.body.length).all()


def test_the_tightest_turn_is_at_200_deg_tail_first_as_on_the_paper_s_grid(turning: Turning) -> None:
    best, ahead, length = turning.tightest, turning.forward, turning.robot.body.length
    assert best is not None
    assert ahead is not None
    assert math.degrees(best.gait.phase[1]) == pytest.approx(200)
    assert best.turn_radius / length == pytest.approx(0.71, abs=0.005)
    assert best.speed < 0 < ahead.speed
    assert 160 < math.degrees(best.phase_between) < 240
    assert best.turn_radius_between < best.turn_radius
    for nearby in (-0.05, 0.05):
        gait = ht.Gait(2.0, best.gait.amplitude, (0.0, best.phase_between + nearby), best.gait.bias)
        assert ht.swim(turning.robot, gait).turn_radius > best.turn_radius_between


def test_a_seek_between_phases_does_not_change_the_way(tuna: ht.Robot) -> None:
    gait = named_gait(tuna, "turning")
    ahead = ht.Gait(2.0, gait.amplitude, (0.0, math.radians(160)), gait.bias)
    phase, radius = tightest(tuna, ahead, low=math.radians(120), high=math.radians(200))
    assert ht.swim(tuna, ht.Gait(2.0, gait.amplitude, (0.0, phase), gait.bias)).speed > 0
    assert radius <= ht.swim(tuna, ahead).turn_radius


def test_a_point_behind_the_nose_has_its_own_radius(turning: Turning) -> None:
    done = ht.swim(turning.robot, turning.tightest.gait)  # type: ignore[union-attr]
    assert point_radius(done, 0.0) == pytest.approx(done.turn_radius, rel=1e-6)
    assert point_radius(done, 0.1) < done.turn_radius  # the head points out of the circle, tail first
    motion = done.continued(60)
    axis = np.exp(1j * motion.heading.values)
    behind = (motion.x.values + 1j * motion.y.values + 0.1 * axis)[:-1]
    assert fit_circle(behind).radius == pytest.approx(point_radius(done, 0.1), rel=1e-5)


def test_on_goes_the_settled_beat(turning: Turning) -> None:
    done = ht.swim(turning.robot, turning.tightest.gait)  # type: ignore[union-attr]
    three = done.continued(3)
    np.testing.assert_allclose(three.u.values[-129:], done.trajectory.u.values, atol=1e-6)
    assert len(nose_path(done)) == 32 * math.ceil(2 * math.pi * 2 / done.turn_rate)


def test_gaits_that_do_not_turn_have_no_circle(tuna: ht.Robot) -> None:
    straight = turn(tuna, ht.Gaits.grid(frequency=[2.0], amplitude=[(0.2, 0.3)], phase=[(0.0, 0.5)]))
    assert np.isinf(straight.sweep.circle_radius.item())
    assert straight.tightest is straight.forward is None
    with pytest.raises(ht.InputError, match="must show a gait that turns"):
        plot_turn(straight)


def test_scaled_multiplies_numbers_of_the_file(tuna: ht.Robot) -> None:
    scaled = runpy.run_path(str(Path(__file__).parents[2] / "docs" / "figures_turn.py"))["scaled"]
    other = scaled(tuna, {"water.lumped.drag[0]": 2.0, "links.lateral_area_m2[7]": 0.5})
    assert other.water.lumped is not None
    assert tuna.water.lumped is not None
    assert other.water.lumped.drag[0] == 2 * tuna.water.lumped.drag[0]
    assert other.links.lateral_area[7] == tuna.links.lateral_area[7] / 2
    assert other.water.lumped.drag[1:] == tuna.water.lumped.drag[1:]
    for key in ("water.lumped.drag", "water.lumped.drag[9]", "water.none[0]"):
        with pytest.raises(ht.InputError, match="must be a number of a list"):
            scaled(tuna, {key: 2.0})


# --- the command


def test_the_command_tells_what_the_function_does(run: Run, turning: Turning, tmp_path: Path) -> None:
    files = [str(tmp_path / name) for name in ("turn.svg", "turn.csv", "turn.nc")]
    options = ("turn", "--robot", "hypertuna", "--gait", "turning", "--phase", "0,160:240:3")
    code, output, _ = run(*options, "--json", "--plot", files[0], "-o", files[1])
    told = json.loads(output)
    assert code == 0
    radii = turning.sweep.turn_radius.values.ravel() / turning.robot.body.length
    np.testing.assert_allclose([row["turn_radius_bl"] for row in told["turns"]], radii, rtol=1e-9)
    assert told["tightest"]["phase_deg"] == [0, 200]
    assert told["tightest_forward"]["phase_deg"] == [0, 160]
    rows = np.genfromtxt(files[1], delimiter=",", names=True, dtype=None, encoding="utf-8")
    np.testing.assert_allclose(rows["turn_radius_bl"], radii, rtol=1e-9)
    assert "from above" in Path(files[0]).read_text()
    code, output, _ = run(*options, "-o", files[2])
    assert "The tightest turn: 0.709 BL at 200 deg, 2 Hz, tail first" in output
    with xr.open_dataset(files[2], engine="h5netcdf") as found:
        np.testing.assert_allclose(found.circle_radius, turning.sweep.circle_radius)


def test_the_phase_goes_once_around(run: Run) -> None:
    code, output, _ = run("turn", "--robot", "rexeel", "--gait", "wave-30", "--json")
    told = json.loads(output)
    assert [row["phase_deg"][-1] for row in told["turns"]] == [0, 40, 80, 120, 160, 200, 240, 280, 320]
    assert {tuple(row["phase_deg"][:-1]) for row in told["turns"]} == {tuple(told["turns"][0]["phase_deg"][:-1])}
    assert code == 1  # without a bias


def test_without_bias_nothing_turns(run: Run) -> None:
    code, output, _ = run("turn", "--robot", "hypertuna", "--gait", "optimised-0.5", "--phase", "0,40", "--json")
    told = json.loads(output)
    assert code == 1
    assert told["tightest"] is None
    assert "give the joints a bias" in told["status_text"][0]


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ((), "--frequency and --amplitude are missing"),
        (("--gait", "turning", "--bias", "1"), "--bias must be 2 values, for joint groups I, II"),
        (("--gait", "turning", "--phase", "0,x"), "--phase[1] must be a number"),
        (
            ("--gait", "turning", "--bias", "0:20:100,0:20:100"),
            "the number of gaits must be at most 2000, but is 90000",
        ),
        (("--gait", "turning", "--plot", "a.gif"), "--plot must end in"),
        (("--gait", "turning", "-o", "a.txt"), "--output must end in .nc or .csv"),
        (("--gait", "turnin"), "did you mean turning?"),
    ],
)
def test_bad_input_is_one_sentence(run: Run, options: tuple[str, ...], sentence: str) -> None:
    code, output, errors = run("turn", "--robot", "hypertuna", *options)
    assert (code, output) == (2, "")
    assert sentence in errors
    assert errors.count("\n") == 1


def test_a_figure_goes_along_what_varies_even_by_two_values(tuna: ht.Robot) -> None:
    gait = named_gait(tuna, "turning")
    biases = [gait.bias, tuple(0.8 * angle for angle in gait.bias)]
    phase = [(0.0, math.radians(160))]
    two = turn(tuna, ht.Gaits.grid(frequency=[2.0], amplitude=[gait.amplitude], phase=phase, bias=biases))
    upper, lower = plot_turn(two).axes
    assert upper.get_xlabel() == "bias [deg]"
    assert two.tightest is not None
    assert two.tightest.speed > 0  # so that it is the tightest head first, too, and drawn once
    ways = [str(line.get_label()) for line in lower.lines if "tightest" in str(line.get_label())]
    assert len(ways) == 1
    assert ways[0].startswith("tightest head first, 160°, 2 Hz")


def test_a_figure_has_the_tightest_turn_of_each_way(turning: Turning) -> None:
    labels = " ".join(str(line.get_label()) for line in plot_turn(turning).axes[1].lines)
    assert "tightest tail first, 200°" in labels
    assert "tightest head first" in labels
