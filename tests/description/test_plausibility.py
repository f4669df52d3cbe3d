"""Unlikely values are reported, each in a sentence with the unit that was likely meant; likely ones are not."""

import copy
import tomllib
from pathlib import Path
from typing import Any

import pytest

from hypertuna.actuation.new import first_robot
from hypertuna.description.new import new_robot
from hypertuna.description.plausibility import implausible
from hypertuna.description.robot import load, parse, robots
from hypertuna.errors import InputError

MINNOW = Path(__file__).parents[2] / "examples" / "minnow.toml"
FISH = new_robot("fish", links=3, length=0.3, mass=0.85)


@pytest.mark.parametrize("name", [*robots(), MINNOW])
def test_nothing_is_unlikely_about_known_robots(name: str | Path) -> None:
    assert implausible(load(name)) == []


@pytest.mark.parametrize("actuation", ["none", "servo", "hydraulic"])
@pytest.mark.parametrize(("links", "length", "mass"), [(3, 0.3, 0.85), (5, 1.5, 60.0), (2, 0.1, 0.02)])
def test_nothing_is_unlikely_about_first_robots(actuation: str, links: int, length: float, mass: float) -> None:
    text = first_robot("fish", links=links, length=length, mass=mass, actuation=actuation)
    assert implausible(parse(tomllib.loads(text))) == []


@pytest.mark.parametrize(
    ("place", "value", "sentence"),
    [
        (("gaits", "cruise", "amplitude_deg"), [0.28, 0.42], "amplitude_deg has 0.42 deg; usual are 1.6 to 180: "
         "is it in radians? Then write 24.0642."),
        (("links", "lateral_area_m2"), [136.3, 56.42, 45.32], "links.lateral_area_m2[0] makes link head 909 m high "
         "on average: is it in cm^2? Then write 0.01363."),
        (("links", "mass_kg"), [0.60933, 0.2041, 0.00003657], "links.mass_kg[2] gives link fin "),
        (("body", "mass_kg"), 8.5, "body.mass_kg is 8.5 kg, but links.mass_kg adds up to 0.85 kg: check both."),
        (("links", "com_m"), [0.085, 0.0031, 0.022], "links.com_m[1] is 0.0031 m, at the front end of a link of "
         "0.075 m: check the unit and the power of ten."),
        (("body", "mass_kg"), 850.0, "body.mass_kg has 850 kg; a slender fish of 0.3 m has about 0.54 kg: check both."),
        (("links", "wetted_area_m2"), [0.00003479, 0.0144, 0.00982], "links.wetted_area_m2[0] is 0.00255 times the "),
        (("water", "density_kg_m3"), 1.0, "water.density_kg_m3 has 1 kg/m^3; usual are 900 to 1300: is it in g/cm^3? "
         "Then write 1000."),
        (("gaits", "cruise", "frequency_hz"), 120.0, "gaits.cruise.frequency_hz has 120 Hz; usual are 0.02 to 20: "
         "check the unit and the power of ten."),
    ],
)  # fmt: skip
def test_slips_are_told(place: tuple[str, ...], value: Any, sentence: str) -> None:
    document: Any = copy.deepcopy(FISH)
    table = document
    for part in place[:-1]:
        table = table[part]
    table[place[-1]] = value
    document["sources"] = {}
    assert sentence in "\n".join(implausible(parse(document)))


@pytest.mark.parametrize(
    ("place", "value", "sentence"),
    [
        (("joints", 0, "pressure_max_pa"), 0.25, "joints[0].pressure_max_pa has 0.25 Pa; usual are 2000 to 5e+06: "
         "is it in MPa? Then write 250000."),
        (("materials", "EC50", "modulus_fe_pa"), 0.08, "materials.EC50.modulus_fe_pa has 0.08 Pa"),
        (("oil", "viscosity_40_m2_s"), 46.0, "usual are 3e-07 to 0.01: is it in mm^2/s? Then write 4.6e-05."),
        (("guidance", "speed_m_s"), [24.3, 29.8, 34.7],
         "guidance.speed_m_s is up to 66.7 lengths per second; fish swim at 0.5 to 10: is it in cm/s? "
         "Then write 0.347."),
        (("drive_unit", "braid_angle_deg"), 0.61, "has 0.61 deg; usual are 5 to 54.7: is it in radians? "
         "Then write 34.95"),
        (("oil", "density_kg_m3"), 0.87, "is it in g/cm^3? Then write 870."),
        (("joints", 0, "pressure_max_pa"), 250.0, "is it in kPa? Then write 250000."),
        (("joints", 0, "line", "fill_pressure_pa"), 60.0, "is it in kPa? Then write 60000."),
        (("joints", 0, "bend_max_deg"), 0.32, "is it in radians? Then write 18.3346."),
        (("battery", "resistance_ohm"), 35.0, "battery.resistance_ohm has 35 ohm; usual are 0.001 to 1"),
        (("guidance", "turn_max_deg_s"), 0.3, "guidance.turn_max_deg_s has 0.3 deg/s; usual are 1.6 to 400"),
        (("firmware", "tilt_max_deg"), 1.05, "is it in radians? Then write 60.1606."),
        (("battery", "capacity_ah"), 3500.0, "battery.capacity_ah has 3500 A h; usual are 0.02 to 500: is it in mAh? "
         "Then write 3.5."),
    ],
)  # fmt: skip
def test_slips_of_hydraulics_are_told(place: tuple[Any, ...], value: Any, sentence: str) -> None:
    document: Any = load("hypertuna").document()
    table = document
    for part in place[:-1]:
        table = table[part]
    table[place[-1]] = value
    told = implausible(parse(document))
    assert sentence in "\n".join(told)


@pytest.mark.parametrize(
    ("place", "value", "sentence"),
    [
        (("oil", "bulk_modulus_pa"), 1500.0, "no liquid is softer, but is 1500: give it in Pa, not MPa or bar"),
        (("joints", 0, "line", "bore_m"), 4.0, "a line is longer than it is wide, but is 4: give both in m"),
    ],
)
def test_what_no_command_could_use_is_refused(place: tuple[Any, ...], value: Any, sentence: str) -> None:
    document: Any = load("hypertuna").document()
    table = document
    for part in place[:-1]:
        table = table[part]
    table[place[-1]] = value
    with pytest.raises(InputError, match=sentence):
        parse(document)


def changed_fish(table: str, key: str, value: Any) -> list[str]:
    """Return what is unlikely about a fish with another value of a table."""
    document: Any = copy.deepcopy(FISH)
    document[table][key] = value
    document["sources"] = {}
    return implausible(parse(document))


@pytest.mark.parametrize(("unit", "factor"), [("mm", 1000), ("cm", 100)])
def test_a_slip_of_unit_in_the_lengths_is_told_once_and_blames_no_key_that_is_not_written(
    unit: str, factor: float
) -> None:
    (told,) = changed_fish("links", "length_m", [0.15 * factor, 0.075 * factor, 0.075 * factor])
    assert told.endswith(f"is it in {unit}? Then write [0.15, 0.075, 0.075].")


def test_links_that_lack_a_third_of_the_mass_are_told() -> None:
    (told,) = changed_fish("links", "mass_kg", [0.35, 0.18, 0.03657])
    assert told == "body.mass_kg is 0.85 kg, but links.mass_kg adds up to 0.5666 kg: check both."


def test_a_fin_larger_than_the_fish_is_told() -> None:
    document = tomllib.loads(first_robot("fish", actuation="servo", sea=True))
    document["fins"] |= {"span_m": 0.9, "y_m": 0.5}
    document["water"]["strip"]["edge_height_m"] = 0.9
    told = implausible(parse(document))
    assert [sentence.split(" has ")[0] for sentence in told] == ["fins.span_m", "water.strip.edge_height_m"]


@pytest.mark.parametrize(
    ("quantity", "noise", "effect"),
    [
        ("depth", 0.03, "only on the way up or down"),
        ("depth", 0.036, ""),
        ("field", 0.0, "only by a reading out of range"),
        ("pressure", 0.0, "may take a working one for a stuck one"),
        ("position", 0.0, ""),
    ],
)
def test_steps_that_hide_a_stuck_sensor_are_told(quantity: str, noise: float, effect: str) -> None:
    document = load("hypertuna").document()
    k = next(k for k, sensor in enumerate(document["sensors"]) if sensor.get("quantity") == quantity)
    document["sensors"][k] |= {"resolution": 0.05, "noise": noise}
    told = implausible(parse(document))
    assert len(told) == bool(effect)
    assert all(f"sensors[{k}].resolution" in sentence and effect in sentence for sentence in told)
