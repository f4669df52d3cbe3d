"""Figure of a robot's wiring: the board with all its pins, and the part at each that is used."""

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch

from hypertuna.display import plots
from hypertuna.figures import BODY, COLORS, EDGE, FAINT, INK, WIDTH, styled
from hypertuna.firmware.wiring import Wire, Wiring

# The pins along both edges of a Teensy 4.1, its USB socket on top, by PJRC's card.
LEFT = ("GND", *map(str, range(13)), "3.3V", *map(str, range(24, 33)))
RIGHT = ("5V", "GND", "3.3V", *map(str, range(23, 12, -1)), "GND", *map(str, range(41, 32, -1)))
# Buses, in the order of their colors.
BUSES = ("pulses", "analog", "digital", "Serial", "I2C")
HALF, REACH = 1.0, 4.6  # half widths of the board and of the figure


@plots.of(Wiring)
@styled
def plot_wiring(wiring: Wiring, *, width: float = WIDTH) -> Figure:
    """Plot the board from above with the part at every used pin: `width` [inch]."""
    figure = Figure(figsize=(width, 0.9 * width))
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set_axis_off()
    rows = len(LEFT)
    axes.set(xlim=(-REACH, REACH), ylim=(-rows - 1.6, 1.6))
    board = FancyBboxPatch((-HALF, -rows - 0.1), 2 * HALF, rows + 0.2, boxstyle="round,pad=0.1", fc=BODY, ec=EDGE)
    axes.add_patch(board)
    axes.add_patch(FancyBboxPatch((-0.35, -0.2), 0.7, 0.9, boxstyle="square,pad=0", fc="white", ec=EDGE))
    axes.text(0, 0.25, "USB", ha="center", va="center", color=FAINT, fontsize=7)
    axes.text(0, -rows / 2, "Teensy 4.1\nseen from above", ha="center", va="center", rotation=90, color=INK)
    wires = {str(wire.pin): wire for wire in wiring.wires}
    for side, names in ((-1, LEFT), (1, RIGHT)):
        for row, name in enumerate(names):
            _draw_pin(axes, side, -row - 0.5, name, wires.pop(name, None))
    _draw_legend(axes, wiring, -rows - 1.0)
    return figure


def color_of(wire: Wire) -> str:
    """Return the color of a wire's bus."""
    return COLORS[next(k for k, bus in enumerate(BUSES) if wire.bus.startswith(bus))]


def _draw_pin(axes: Axes, side: int, y: float, name: str, wire: Wire | None) -> None:
    """Draw a pin with its name, and the wire to its part."""
    power = not name.isdigit()
    used = wire is not None or power
    axes.text(side * (HALF - 0.12), y, name, ha="left" if side < 0 else "right", va="center",
              fontsize=7.5, color=INK if used else EDGE, weight="bold" if wire else "normal")  # fmt: skip
    axes.plot([side * HALF], [y], "o", ms=4, color=EDGE if wire is None else color_of(wire))
    if wire is None:
        return
    color, x_end = color_of(wire), HALF + 0.45
    axes.plot([side * HALF, side * x_end], [y, y], color=color, lw=1.4)
    if wire.to != "both":
        tip = x_end if wire.to == "part" else HALF + 0.16
        axes.plot([side * tip], [y], marker=">" if (wire.to == "part") == (side > 0) else "<", ms=5, color=color)
    text = f"{wire.part}: {wire.signal}" if wire.bus not in ("pulses", "analog") else f"{wire.part} ({wire.signal})"
    axes.text(side * (x_end + 0.12), y, text, ha="right" if side < 0 else "left", va="center", fontsize=7.2)


def _draw_legend(axes: Axes, wiring: Wiring, y: float) -> None:
    """Draw the legend: the color of each bus that the robot has."""
    entries: dict[str, str] = {}
    for wire in wiring.wires:
        rate = f", {wire.rate:,} bit/s" if wire.rate and wire.bus != "I2C" else ""
        entries.setdefault("Serial ports" if wire.bus.startswith("Serial") else wire.bus + rate, color_of(wire))
    for k, (text, color) in enumerate(entries.items()):
        x = -REACH + 0.4 + k * 1.8
        axes.plot([x, x + 0.3], [y, y], color=color, lw=2.5)
        axes.text(x + 0.4, y, text, va="center", fontsize=8)
