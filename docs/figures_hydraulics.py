"""Tables and picture of docs/hydraulics.md; docs/figures.py includes them."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

from figures_common import FISH, PAPER, paper_value, rows
from matplotlib.figure import Figure

from hypertuna.actuation.plots import plot_pump
from hypertuna.actuation.sizing import Size, largest_beat, size_pump
from hypertuna.description.robot import parse
from hypertuna.simulation.losses import Losses
from hypertuna.simulation.plots_losses import plot_losses
from hypertuna.simulation.twin import twin
from hypertuna.swimming.gait import named_gait

GAITS = ("unoptimised-max", "optimised-0.5")  # whose power is published


def servo_power_table() -> str:
    """Tabulate the twin's electrical power in the two gaits of published power, with one value of the robot changed."""
    cost, lake = paper_value("cost-of-transport/minimum"), PAPER["lake"]
    body = [["published", f"{cost * FISH.body.mass * paper_value('speed/unoptimised-max'):.3g}", "", ""]]
    body[0][2] = f"{lake['energy_wh'] / 0.5:.3g}"  # in 30 minutes
    servo = next(k for k, s in enumerate(FISH.servos) if s.drives == "piston pump")
    cases: dict[str, tuple[str, dict[str, float]]] = {
        "the twin": ("", {}),
        "position loop of 15 Hz": ("servos", {"bandwidth_hz": 15.0}),
        "rotor of 0.009 kg m²": ("servos", {"inertia_kg_m2": 0.009}),
        "friction of the gears of 0.6 N m": ("servos", {"friction_n_m": 0.6}),
        "idle current of 0.3 A": ("servos", {"idle_current_a": 0.3}),
        "stall current of 11 A": ("servos", {"stall_current_a": 11.0}),
        "no friction of the seals": ("pump", {"seal_friction_n": 0.0}),
        "seals of 25 N": ("pump", {"seal_friction_n": 25.0}),
        "oil of 35 C": ("oil", {"temperature_c": 35.0}),
        "lines of 3 mm": ("line", {"bore_m": 0.003}),
        "lines of 5 mm": ("line", {"bore_m": 0.005}),
    }
    for name, (where, values) in cases.items():
        document = FISH.document()
        tables = {"servos": [document["servos"][servo]]} | {key: [document[key]] for key in ("oil", "pump")}
        for table in tables.get(where, [group["line"] for group in document["joints"]] if where else []):
            table.update(values)
        robot = parse(document)
        runs = [twin(robot, named_gait(robot, gait), duration=12) for gait in GAITS]
        body.append(
            [name, *(f"{run.electrical_power:.3g}" for run in runs), ", ".join(f"{run.speed:.2f}" for run in runs)]
        )
    return rows(("", "fastest gait [W]", "lake gait [W]", "their speeds [m/s]"), body)


@cache
def losses() -> list[Losses]:
    """Return the losses of power in the two gaits."""
    return [twin(FISH, named_gait(FISH, gait), duration=12).losses for gait in GAITS]


def loss_table() -> str:
    """Tabulate the twin's losses in the two gaits."""
    fastest, lake = losses()
    body = [
        [one.place, one.name, one.text, f"{one.power:z.2f}", f"{other.power:z.2f}"]
        for one, other in zip(fastest.losses, lake.losses, strict=True)
    ]
    body.append(["", "all", "power of the cells", f"{fastest.power:.2f}", f"{lake.power:.2f}"])
    return rows(("place", "loss", "what it is", "fastest gait [W]", "lake gait [W]"), body, left=3)


@cache
def sizes() -> list[Size]:
    """Size the pump over bore and temperature."""
    frequency, amplitude = largest_beat(FISH)
    celsius = (5, 10, 15, 20, 25, 30)
    bores, kelvin = [2e-3, 3e-3, 4e-3, 5e-3], [273.15 + t for t in celsius]
    return size_pump(FISH, frequency=[frequency], amplitude=amplitude, bore=bores, temperature=kelvin)


TABLES: dict[str, Callable[[], str]] = {"losses": loss_table, "servo power": servo_power_table}
PICTURES: dict[str, Callable[[], Figure]] = {
    "docs/pump.svg": lambda: plot_pump(sizes()),
    "docs/losses.svg": lambda: plot_losses(losses()[0]),
}
