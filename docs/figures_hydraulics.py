"""Tables and picture of docs/hydraulics.md; docs/figures.py takes them in."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

from figures_common import FISH, PAPER, rows, told
from matplotlib.figure import Figure

from hypertuna.actuation.plots import plot_pump
from hypertuna.actuation.sizing import Size, largest_beat, size_pump
from hypertuna.description.robot import parse
from hypertuna.simulation.twin import twin
from hypertuna.swimming.gait import named_gait


def servo_power_table() -> str:
    """Tabulate the twin's electrical power in the two gaits whose power is published, over what it hangs on."""
    cost, lake = told("cost-of-transport/minimum"), PAPER["lake"]
    body = [["published", f"{cost * FISH.body.mass * told('speed/unoptimised-max'):.3g}", "", ""]]
    body[0][2] = f"{lake['energy_wh'] / 0.5:.3g}"  # in 30 minutes
    servo = next(k for k, s in enumerate(FISH.servos) if s.drives == "piston pump")
    stiff = {"bandwidth_hz": 20.0, "inertia_kg_m2": 0.009, "idle_current_a": 0.3}
    cases: dict[str, tuple[str, dict[str, float]]] = {
        "the twin": ("", {}),
        "first guess: 20 Hz, 0.009 kg m², 0.3 A": ("servos", stiff),
        "position loop of 15 Hz instead of 10": ("servos", {"bandwidth_hz": 15.0}),
        "rotor twice as heavy": ("servos", {"inertia_kg_m2": 0.009}),
        "twice the friction": ("servos", {"friction_n_m": 0.6}),
        "idle current of 0.3 A instead of 0.05": ("servos", {"idle_current_a": 0.3}),
        "oil of 35 C": ("oil", {"temperature_c": 35.0}),
        "lines of 3 mm": ("line", {"bore_m": 0.003}),
        "lines of 5 mm": ("line", {"bore_m": 0.005}),
    }
    for name, (where, values) in cases.items():
        document = FISH.document()
        tables = {"servos": [document["servos"][servo]], "oil": [document["oil"]]}
        for table in tables.get(where, [group["line"] for group in document["joints"]] if where else []):
            table.update(values)
        robot = parse(document)
        runs = [twin(robot, named_gait(robot, gait), duration=12) for gait in ("unoptimised-max", "optimised-0.5")]
        body.append(
            [name, *(f"{run.electrical_power:.3g}" for run in runs), ", ".join(f"{run.speed:.2f}" for run in runs)]
        )
    return rows(("", "fastest gait [W]", "lake gait [W]", "their speeds [m/s]"), body)


@cache
def sizes() -> list[Size]:
    """Size the pump over bore and temperature."""
    frequency, amplitude = largest_beat(FISH)
    celsius = (5, 10, 15, 20, 25, 30)
    bores, kelvin = [2e-3, 3e-3, 4e-3, 5e-3], [273.15 + t for t in celsius]
    return size_pump(FISH, frequency=[frequency], amplitude=amplitude, bore=bores, temperature=kelvin)


TABLES: dict[str, Callable[[], str]] = {"servo power": servo_power_table}
PICTURES: dict[str, Callable[[], Figure]] = {"docs/pump.svg": lambda: plot_pump(sizes())}
