"""Figures show what was computed, with axes and units, and are written whole."""

import itertools
import math
import tomllib
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.text import Text
from numpy.testing import assert_allclose
from PIL import Image

import hypertuna as ht
from hypertuna.actuation.new import first_robot
from hypertuna.description.plots import plot_robot
from hypertuna.description.robot import parse
from hypertuna.figures import save, sequence, styled
from hypertuna.optimization.plots import plot_convergence
from hypertuna.swimming.gait import named_gait
from hypertuna.swimming.outline import FRAMES, last_beat, outlines, slowed, specks, swimming_svg
from hypertuna.swimming.plots import animate_swim, plot_ledger, plot_sweep, plot_swim, unroll
from hypertuna.swimming.plots_turn import plot_turning


@pytest.fixture(scope="module")
def fish() -> ht.Robot:
    return ht.load("hypertuna")


@pytest.fixture(scope="module")
def fast(fish: ht.Robot) -> ht.Swim:
    return ht.swim(fish, named_gait(fish, "unoptimised-max"))


@pytest.fixture(scope="module")
def tank(fish: ht.Robot) -> xr.Dataset:
    phases = [(0.0, phase) for phase in np.radians([0, 40, 80])]
    levels = np.radians([(8, 15), (16, 25)]).tolist()
    return ht.sweep(fish, ht.Gaits.grid(frequency=[2.0, 4.0, 6.0], amplitude=levels, phase=phases))


def labels(figure: Figure) -> list[str]:
    """Labels of all axes that have any."""
    return [text for axes in figure.axes for text in (axes.get_xlabel(), axes.get_ylabel()) if text]


def test_swim_shows_the_beat(fast: ht.Swim) -> None:
    figure = plot_swim(fast)
    _, midlines, speed, power = figure.axes[:4]
    assert_allclose(speed.lines[0].get_ydata(), fast.trajectory.forward_speed)
    assert_allclose(power.lines[-2].get_ydata(), fast.trajectory.mechanical_power)
    assert_allclose(power.lines[-2].get_xdata(), np.linspace(0, 1, fast.steps + 1))
    assert_allclose(np.mean(power.lines[-1].get_ydata()), fast.mechanical_power)
    assert len(midlines.lines) > 8
    lengths = [np.hypot(*np.diff(line.get_xydata(), axis=0).T).sum() for line in midlines.lines]
    assert_allclose(lengths, fast.robot.body.length)
    assert all("[" in label for label in labels(figure) if not label.startswith("part"))


def test_no_entry_of_a_legend_is_like_another() -> None:
    """Of more joint groups than there are colors, dashes and shapes tell those of one color apart."""
    many = parse(tomllib.loads(first_robot("fish", links=14)))
    swim = ht.swim(many, named_gait(many, next(iter(many.gaits))))
    for figure in (plot_swim(swim), plot_robot(many)):
        for axes in figure.axes:
            lines = axes.get_legend_handles_labels()[0]
            looks = [(line.get_color(), str(line._dash_pattern), line.get_marker()) for line in lines]
            assert len(set(looks)) == len(looks), looks


@pytest.mark.parametrize("turning", [False, True])
def test_paths_repeat_the_beat(fish: ht.Robot, turning: bool) -> None:
    gait = named_gait(fish, "turning" if turning else "unoptimised-max")
    swim = ht.swim(fish, gait)
    motion, beats = swim.trajectory, 5
    nose = motion.x.values + 1j * motion.y.values
    path = unroll(nose, motion, beats)
    assert len(path) == beats * swim.steps + 1
    assert_allclose(path[: swim.steps + 1], nose)
    steps = np.abs(np.diff(path)).reshape(beats, -1)
    assert_allclose(steps, np.broadcast_to(steps[0], steps.shape), rtol=1e-6)
    if turning:  # all beats start on a circle of the turn's radius
        corners = path[:: swim.steps]
        heading = float(motion.heading[-1] - motion.heading[0])
        center = (corners[1] - np.exp(1j * heading) * corners[0]) / (1 - np.exp(1j * heading))
        assert_allclose(np.abs(corners - center), np.abs(corners[0] - center))


def test_swim_from_rest_shows_all_of_it(fast: ht.Swim) -> None:
    swim = ht.swim(fast.robot, fast.gait, from_rest=1.0)
    figure = plot_swim(swim)
    assert_allclose(figure.axes[2].lines[0].get_xdata()[-1], 1.0)
    assert "time [s]" in labels(figure)
    assert last_beat(swim).sizes["time"] == swim.steps + 1


def test_last_beat_from_rest_is_whole(fast: ht.Swim) -> None:
    swim = ht.swim(fast.robot, fast.gait, from_rest=2.5 / fast.gait.frequency)
    whole, beat = swim.trajectory, last_beat(swim)
    assert whole.sizes["time"] == 2.5 * swim.steps + 1
    assert_allclose(beat.time[[0, -1]] * fast.gait.frequency, [1, 2])
    assert_allclose(
        np.trapezoid(beat.mechanical_power, beat.time) * fast.gait.frequency, swim.mechanical_power, rtol=1e-3
    )


def test_the_dashed_line_is_the_mean_of_what_is_drawn(fast: ht.Swim) -> None:
    figure = plot_swim(fast)
    axes = figure.axes[2]
    drawn, mean = (np.asarray(line.get_ydata()) for line in axes.lines)
    assert_allclose(mean, drawn[:-1].mean())
    assert axes.get_title("right") == f"mean {mean[0]:.3g} m/s"
    assert f"{fast.speed:.3g} m/s along the path" in figure.get_suptitle()
    figure.draw_without_rendering()
    titles = [text for text in axes.findobj(Text) if text.get_text() in ("Forward speed", axes.get_title("right"))]
    left, right = sorted((text.get_window_extent() for text in titles), key=lambda box: box.x0)
    assert left.x1 < right.x0


def test_sweep_has_a_row_for_each_amplitude_and_a_line_for_each_phase(tank: xr.Dataset) -> None:
    figure = plot_sweep(tank)
    assert len(figure.axes) == 2 * tank.sizes["amplitude"]
    for row in range(2):
        for axes, name in zip(figure.axes[2 * row : 2 * row + 2], ("speed", "cost_of_transport"), strict=True):
            shown = np.array([line.get_ydata() for line in axes.lines])
            assert_allclose(shown, tank[name].isel(amplitude=row, bias=0).transpose("phase", "frequency"))
    assert {"frequency [Hz]", "speed [m/s]", "cost of transport\n[J/(kg m)]"} == set(labels(figure))
    assert figure.axes[0].get_xticks().tolist() == tank.frequency.values.tolist()
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["0°", "40°", "80°"]


def test_sweep_leaves_out_what_is_not_settled(tank: xr.Dataset) -> None:
    settled = tank.settled.copy()
    settled[1, 0, 2, 0] = False
    shown = plot_sweep(tank.assign(settled=settled)).axes[0].lines[2].get_ydata()
    assert np.isnan(shown).tolist() == [False, True, False]


def test_sweep_of_one_frequency_goes_along_the_phase(tank: xr.Dataset) -> None:
    figure = plot_sweep(tank.isel(frequency=[1]))
    assert_allclose(figure.axes[0].lines[0].get_xdata(), [0, 40, 80])
    with pytest.raises(ht.InputError, match="several frequencies or phases"):
        plot_sweep(tank.isel(frequency=[1], phase=[0]))


def test_turning_marks_what_swims_tail_first(fish: ht.Robot) -> None:
    gait = named_gait(fish, "turning")
    phases = [(0.0, phase) for phase in np.radians([0, 100, 200])]
    grid = ht.Gaits.grid(frequency=[gait.frequency], amplitude=[gait.amplitude], phase=phases, bias=[gait.bias])
    found = ht.sweep(fish, grid)
    axes = plot_turning({"model": found}, fish.body.length, published=(200, 0.47)).axes[0]
    line, ahead, backward = axes.lines[:3]
    assert_allclose(line.get_ydata(), found.turn_radius.values.ravel() / fish.body.length)
    assert [list(part.get_xdata()) for part in (ahead, backward)] == [pytest.approx([0, 100]), pytest.approx([200])]
    assert to_hex(backward.get_markerfacecolor()) == "#ffffff"
    assert "turning radius" in plot_sweep(found).axes[2].get_ylabel()


def test_ledger_shows_every_number() -> None:
    computed = {"one": [1.1, 2.2], "two": [0.9, 1.8]}
    axes = plot_ledger(["a", "b"], [1.0, 2.0], computed, label="speed [m/s]").axes[0]
    shown = {line.get_label(): list(line.get_xdata()) for line in axes.lines}
    assert shown == {"published": [1.0, 2.0], **computed}
    assert [text.get_text() for text in axes.get_yticklabels()] == ["a", "b"]


def test_colors_rise_in_lightness() -> None:
    light = [np.dot(color[:3], (0.2126, 0.7152, 0.0722)) for color in sequence(6)]
    assert (np.diff(light) > 0).all()


def test_the_look_does_not_leak(fast: ht.Swim) -> None:
    import matplotlib

    before = dict(matplotlib.rcParams)
    plot_swim(fast)
    assert dict(matplotlib.rcParams) == before


@pytest.mark.parametrize("suffix", [".svg", ".png", ".pdf"])
def test_figures_are_written_the_same_each_time(fast: ht.Swim, tmp_path: Path, suffix: str) -> None:
    files = [tmp_path / f"{k}{suffix}" for k in range(2 if suffix == ".svg" else 1)]
    for file in files:
        save(plot_swim(fast), file)
    if suffix == ".svg":
        assert files[0].read_bytes() == files[1].read_bytes()
    assert files[0].stat().st_size > 5000


def test_outlines_follow_the_body(fast: ht.Swim) -> None:
    shapes, step = outlines(fast)
    tails = shapes[:, shapes.shape[1] // 2, 1]
    excursion = fast.tail_excursion / fast.robot.body.length
    assert np.ptp(tails) == pytest.approx(excursion, rel=0.15)  # smooth between the joints, one frame in 32
    assert step[0] == pytest.approx(fast.stride_length, rel=0.02)
    assert abs(step[1]) < 0.02


def test_animation_is_a_seamless_gif(fast: ht.Swim, tmp_path: Path) -> None:
    file = tmp_path / "swim.gif"
    animate_swim(fast, file)
    with Image.open(file) as film:
        assert (film.format, film.n_frames) == ("GIF", FRAMES)  # type: ignore[attr-defined]
        assert film.info["loop"] == 0
        frames = []
        for k in range(FRAMES):
            film.seek(k)
            frames.append(np.asarray(film.convert("L"), dtype=float))
    changes = [np.abs(a - b).mean() for a, b in zip(frames, [*frames[1:], frames[0]], strict=True)]
    assert changes[-1] < 1.2 * max(changes[:-1])  # the last frame leads to the first as any other to its next
    assert min(changes) > 0


def test_times_on_the_screen_are_told(fish: ht.Robot, fast: ht.Swim) -> None:
    assert slowed(fast) == "slowed down 7.7 times"
    assert "animateTransform" in swimming_svg(fast)


def test_lines_of_a_sweep_have_colors_that_differ_and_name_their_joint(tuna: ht.Robot) -> None:
    """Of 2 to 6 phases no two are both blue."""
    for count in range(2, 7):
        gaits = ht.Gaits.grid_degrees(frequency=[1, 2], amplitude=[(16, 25)], phase=[(0, 30 * k) for k in range(count)])
        (legend,) = ht.plot_sweep(ht.sweep(tuna, gaits)).legends
        assert legend.get_title().get_text() == "phase of joint II"
        colors = [to_rgb(line.get_color()) for line in legend.get_lines()]
        assert len(colors) == count
        assert min(math.dist(one, other) for one, other in itertools.combinations(colors, 2)) > 0.25


def test_convergence_of_several_runs_has_colors_that_differ(tuna: ht.Robot) -> None:
    runs = [ht.optimize(tuna, maximize="speed", method="pso", particles=4, iterations=2, seed=k) for k in range(1, 5)]
    (axes,) = plot_convergence(runs).axes
    legend = axes.get_legend()
    assert legend is not None
    colors = [to_rgb(line.get_color()) for line in legend.get_lines()]
    assert min(math.dist(one, other) for one, other in itertools.combinations(colors, 2)) > 0.25


@pytest.mark.parametrize(("mean", "tick"), [(6.12e-11, "0.00"), (250.0, "250"), (-3.0, "−3.00")])
def test_axes_do_not_show_rounding(mean: float, tick: str) -> None:
    """What is constant but for rounding is a flat line, without ticks such as +6.12e-11."""

    @styled
    def plot() -> Figure:
        figure = Figure()
        figure.subplots().plot([0, 1, 2], mean + np.array([0, 1e-12, -1e-12]))
        return figure

    figure = plot()
    figure.draw_without_rendering()
    (axes,) = figure.axes
    texts = [text.get_text() for text in axes.get_yticklabels()]
    assert tick in texts
    assert axes.yaxis.get_offset_text().get_text() == ""
    assert not [text for text in texts if "e" in text]


@pytest.mark.parametrize(("step", "spacing"), [(0.25, 0.25 / 3), (-0.25, 0.25 / 3), (0.01, 0.08)])
def test_specks_look_the_same_after_a_beat(step: float, spacing: float) -> None:
    """A whole number of specks about 0.08 apart lies on the way of a beat; on a shorter one they are 0.08 apart."""
    dots = specks(np.array([step, 0.0]), 0.2)
    rows = [dots[dots[:, 1] == y, 0] for y in np.unique(dots[:, 1])]
    assert_allclose(np.diff(np.unique(dots[:, 1])), 0.08)
    assert (dots[:, 1].min(), dots[:, 1].max()) == pytest.approx((-0.16, 0.16))  # half a row from the reach
    for k, row in enumerate(rows):
        assert_allclose(np.diff(row), spacing)
        assert row[0] == pytest.approx(-0.3 - abs(step) + spacing * (0.618 * k % 1))
        assert row[-1] > 1.3 + abs(step) - spacing
