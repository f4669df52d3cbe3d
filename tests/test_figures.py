"""Style of figures: lines and colors that differ, axes without rounding, files that are the same at each saving."""

import io
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from matplotlib import pyplot as plt
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.text import Text

from hypertuna import figures
from hypertuna.display import Plotted
from hypertuna.figures import COLORS, LINES, line_style, save, sequence, styled


@styled
def drawn(x: list[float], y: list[float], text: str = "a") -> Figure:
    """A plot in the style."""
    figure = Figure(figsize=(4, 3))
    axes = figure.add_subplot()
    axes.plot(x, y, label=text)
    axes.set_title(text)
    axes.set_xlabel(text)
    axes.margins(0)
    axes.legend(**figures.TIGHT)
    return figure


def test_a_figure_is_in_the_style_whatever_the_user_set() -> None:
    with matplotlib.rc_context({"font.size": 30, "lines.linewidth": 9, "axes.grid": False}):
        figure = drawn([0, 1], [0, 1])
        assert plt.rcParams["font.size"] == 30  # and the user's settings stay
    axes = figure.axes[0]
    sizes = {"title": 9.5, "label": 9, "tick": 9, "legend": 8.5}  # points
    (title,) = (text for text in axes.get_children() if isinstance(text, Text) and text.get_text() == "a")
    legend = axes.get_legend()
    assert axes.get_title(loc="left") == "a"
    assert legend is not None
    assert {
        "title": title.get_fontsize(),
        "label": axes.xaxis.label.get_fontsize(),
        "tick": axes.get_xticklabels()[0].get_fontsize(),
        "legend": legend.get_texts()[0].get_fontsize(),
    } == pytest.approx(sizes)
    assert [axes.spines[side].get_visible() for side in ("left", "bottom", "top", "right")] == [
        True,
        True,
        False,
        False,
    ]
    assert axes.spines["left"].get_linewidth() == 0.8
    grid = axes.get_xgridlines()[0]
    assert grid.get_visible()
    assert grid.get_linewidth() == 0.6
    assert axes.get_axisbelow() is True
    assert axes.lines[0].get_linewidth() == 1.6
    assert not legend.get_frame_on()
    # TIGHT, in units of the letters' size: frame to axes, dash to text, columns, length of a dash
    tight = (legend.borderaxespad, legend.handletextpad, legend.columnspacing, legend.handlelength)
    assert tight == (0.2, 0.5, 1.2, 1.6)
    assert figures.POINTS == {"ms": 4.2, "mec": "white", "mew": 0.5}


def test_large_values_are_written_whole() -> None:
    axes = drawn([0, 1], [100000.0, 100001.0]).axes[0]
    axes.figure.canvas.draw()
    assert axes.yaxis.get_major_formatter().get_offset() == ""


def test_no_line_is_like_another() -> None:
    styles = [line_style(k) for k in range(len(COLORS) * len(LINES))]
    assert len({(one["color"], str(one["ls"])) for one in styles}) == 24
    assert [one["color"] for one in styles[:7]] == [*COLORS, COLORS[0]]
    assert [one["ls"] for one in styles[::6]] == list(LINES)
    assert line_style(24) == styles[0]
    assert line_style(2, first=5)["color"] == COLORS[1]
    assert line_style(2, first=5)["ls"] == "-"


def test_dashes_in_widths_of_the_line() -> None:
    # whole, dashes of 5, dots of 2, dash and dot: each begins with what is drawn
    assert LINES == ("-", (0, (5, 2)), (0, (2, 1.5)), (0, (6, 2, 1.5, 2)))


def test_a_sequence_goes_from_dark_to_light() -> None:
    assert sequence(1) == [COLORS[1]]
    for count in (2, 3, 5):
        colors = [to_hex(color).upper() for color in sequence(count)]
        assert (len(colors), colors[0], colors[-1]) == (count, "#4059A8", "#E3A63C")
        light = [np.dot(color[:3], (0.299, 0.587, 0.114)) for color in sequence(count)]
        assert light == sorted(light)
    np.testing.assert_allclose(sequence(5)[2][:3], np.array([0x22, 0xA3, 0x9B]) / 255, atol=0.005)  # one of 256 steps


@pytest.mark.parametrize(
    ("values", "limits"),
    [
        ((1.0, 2.0), (1.0, 2.0)),
        ((-1e-11, 6e-11), (-1 + 2.5e-11, 1 + 2.5e-11)),  # around zero: 1 to both sides
        ((2.0, 2.0 + 1e-9), (1.9, 2.1)),  # a twentieth of the size to both sides
        ((-4.0 - 1e-9, -4.0), (-4.2, -3.8)),
        ((1e-9, 1.9e-9), (1.45e-9 - 0.05 * 1.9e-9, 1.45e-9 + 0.05 * 1.9e-9)),
        ((0.2e-9, 1.1e-9), (0.65e-9 - 0.055e-9, 0.65e-9 + 0.055e-9)),
        ((0.2e-9, 1e-9), (0.6e-9 - 1, 0.6e-9 + 1)),  # a size of 1e-9 is zero
        ((2.0, 2.0 + 2.2e-9), (2.0, 2.0 + 2.2e-9)),  # more than 1e-9 of the size are values
        ((0.0, 1e-9), (0.0, 1e-9)),
    ],
)
@pytest.mark.parametrize("kind", ["x", "y"])
def test_values_that_differ_by_rounding_are_flat(values: list[float], limits: list[float], kind: str) -> None:
    axes = drawn(*((list(values), [0, 1]) if kind == "x" else ([0, 1], list(values)))).axes[0]
    np.testing.assert_allclose(getattr(axes, f"get_{kind}lim")(), limits, rtol=1e-9)
    np.testing.assert_allclose(getattr(axes, f"get_{'y' if kind == 'x' else 'x'}lim")(), (0, 1))


def test_a_logarithmic_axis_stays_as_it_is() -> None:
    @styled
    def logarithmic() -> Figure:
        figure = Figure()
        axes = figure.add_subplot(xscale="log", xlim=(1e-12, 1e-10))
        axes.plot([1e-12, 1e-10], [0, 1])
        return figure

    assert logarithmic().axes[0].get_xlim() == (1e-12, 1e-10)


@pytest.mark.parametrize("kind", ["svg", "png", "pdf", "PNG"])
def test_a_figure_is_saved(kind: str, tmp_path: Path) -> None:
    path = tmp_path / f"a.{kind}"
    save(drawn([0, 1], [0, 1]), path)
    content = path.read_bytes()
    assert {"svg": b"<?xml", "png": b"\x89PNG", "pdf": b"%PDF"}[kind.lower()] == content[: 5 if kind == "svg" else 4]
    if kind == "png":  # 4 x 3 inches at 200 dots per inch
        assert plt.imread(io.BytesIO(content), format="png").shape[:2] == (600, 800)
    if kind == "svg":
        assert b"<dc:date>" not in content
        save(drawn([0, 1], [0, 1]), path)
        assert path.read_bytes() == content


def test_a_dollar_sign_of_a_name_is_one() -> None:
    figure = drawn([0, 1], [0, 1], "$a$ of b")
    figure.axes[0].set_ylabel(r"$\mathdefault{10^{-3}}$")
    figures.disable_formulas(figure)
    axes = figure.axes[0]
    assert not axes.xaxis.label.get_parse_math()
    assert axes.yaxis.label.get_parse_math()  # as matplotlib writes powers of ten
    plain = drawn([0, 1], [0, 1])
    figures.disable_formulas(plain)
    assert plain.axes[0].xaxis.label.get_parse_math()


def test_a_figure_is_as_wide_as_two_columns() -> None:
    assert Plotted.plot.__kwdefaults__ == {"width": figures.WIDTH} == {"width": 7.2}
