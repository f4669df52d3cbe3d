"""A quantity has one name: its attribute in Python, its key in JSON with the unit, its label on the terminal."""

import json
import re
from typing import Any

import pytest

from hypertuna.actuation.battery import CruisingRange
from hypertuna.actuation.sizing import Size
from hypertuna.io.quantity import columns, key_of, label, suffix, summarized
from hypertuna.mission.flight import OUTCOME, Outcome
from hypertuna.simulation.dive import Leg
from hypertuna.simulation.run import TwinRun
from hypertuna.swimming.beat import QUANTITIES
from hypertuna.swimming.swim import SUMMARY, Swim
from hypertuna.swimming.turn import Tightest

UNITS = ("m", "s", "w", "hz", "deg", "rad_s", "n_m", "m_s", "kpa", "bl", "c", "mm", "km", "h", "wh", "v", "j", "mm2_s")
UNITS = tuple(sorted((*UNITS, "j_per_kg_m", "pa_s_m3", "pa_s2_m3", "m3_pa", "kpa_deg"), key=len, reverse=True))
GAIT = ("--frequency", "2", "--amplitude", "16,24", "--phase", "0,40")

# Commands, and the results whose attributes stand in their JSON object: by their keys' place in it.
COMMANDS: dict[tuple[str, ...], dict[str, Any]] = {
    ("swim", *GAIT, "--bias", "3,0"): {"": Swim},
    ("turn", "--frequency", "2", "--amplitude", "16,24", "--phase", "0,40", "--bias", "12,12"): {"tightest": Tightest},
    ("twin", *GAIT, "--duration", "2"): {"": TwinRun},
    ("pump", "--frequency", "2", "--amplitude", "8,12"): {"sizes": Size},
    ("range", "--power", "20", "--speed", "0.5"): {"": CruisingRange},
    ("dive", *GAIT, "--duration", "4"): {"legs": Leg},
}
# Keys that are no quantity of the result: what was asked for, what made it, and tables of other things.
OTHERS = frozenset(
    """
    status status_text settled reached_from_rest settled_from_rest warnings frequency_hz amplitude_deg
    phase_deg bias_deg robot robot_hash robot_file hypertuna_version model water areas command joints isa
    sources published fit name gait limits circuits faults medium start seed closed_loop
    circle_radius_bl circle_residual_m
    depth_from_m depth_to_m steady turbulent battery mass_kg duration_s from_rest_s current_m_s frame legs
    """.split()  # noqa: SIM905 - a list of words
)


def base(key: str) -> str:
    """Return the name of a key without its unit."""
    return next((key.removesuffix(f"_{unit}") for unit in UNITS if key.endswith(f"_{unit}")), key)


def attribute(kind: type, name: str) -> bool:
    """Whether a class has an attribute or a field."""
    return hasattr(kind, name) or name in getattr(kind, "__dataclass_fields__", {})


@pytest.mark.parametrize("arguments", COMMANDS, ids=lambda arguments: arguments[0])
def test_json_has_the_names_of_python(run, arguments) -> None:
    code, output, _ = run(*arguments, "--json")
    assert code in (0, 1)
    record = json.loads(output)
    for place, kind in COMMANDS[arguments].items():
        rows = record[place] if place else record
        row = rows[0] if isinstance(rows, list) else rows
        unknown = [key for key in row if key not in OTHERS and not attribute(kind, base(key))]
        unknown = [key for key in unknown if not attribute(kind, key.removesuffix("_s"))]  # body lengths per second
        assert [key for key in unknown if not key.startswith("electrical_power")] == []


@pytest.mark.parametrize("arguments", COMMANDS, ids=lambda arguments: arguments[0])
def test_the_terminal_has_the_names_of_python(run, arguments) -> None:
    if arguments[0] in ("turn", "dive"):  # tables and sentences
        return
    _, output, _ = run(*arguments)
    kinds = [*COMMANDS[arguments].values()]
    names = {word for kind in kinds for word in (*dir(kind), *getattr(kind, "__dataclass_fields__", {}))}
    known = {label(name) for name in names if not name.startswith("_")}
    known |= {"oil", "line", "limited by", "battery", "water"}
    labels = re.findall(r"^ *([A-Za-z][a-z A-Z]+?)(?:, [a-z ]+?)? {2,}[-\d–]", output, re.MULTILINE)
    assert labels
    assert [one for one in labels if one not in known and one.strip() not in ("I", "II")] == []


def test_columns_of_sweeps_are_the_attributes_of_a_swim() -> None:
    assert QUANTITIES.keys() <= Swim.__dataclass_fields__.keys()
    assert SUMMARY.keys() <= QUANTITIES.keys()
    for name, (unit, _) in SUMMARY.items():
        assert key_of(name, unit) == name + suffix(QUANTITIES[name].unit)


def test_flights_have_the_names_of_python() -> None:
    one = Outcome(3, "done", 4, 0, 0, 60.0, 30.0, 7200.0, 0.9, 1.5, 5.0, 2.0, 1.0, 1.6, {}, [])
    summary = summarized(one, OUTCOME)
    assert [base(key) for key in summary] == [*OUTCOME]
    assert summary["energy_wh"] == (2.0, "Wh", "energy, from the battery")
    assert summary["depth_max_m"].label == "max depth"


def test_names_units_and_labels() -> None:
    assert key_of("speed_bl", "BL/s") == "speed_bl_s"
    assert key_of("turn_radius_bl", "BL") == "turn_radius_bl"
    assert key_of("cost_of_transport", "J/(kg m)") == "cost_of_transport_j_per_kg_m"
    assert [label(name) for name in ("strouhal", "pressure_max", "speed_bl")] == [
        "Strouhal number",
        "max pressure",
        "speed",
    ]
    battery = CruisingRange(20.0, 0.5, 12.0, 0.1, 3600.0, 7200.0, (16.0, 14.0), 6.0, 2000.0, 3600.0, 3000.0, 7200.0)
    told = columns(battery)
    assert (told["electrical_power_w"], told["range_km"], told["energy_at_servos_wh"]) == (20.0, 2.0, 2.0)
