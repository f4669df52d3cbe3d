"""A key is declared once: how many files name it, and that no list elsewhere repeats it."""

import re
import subprocess
from functools import cache
from pathlib import Path

import pytest

import hypertuna as ht
from hypertuna.control.controller import given_constants
from hypertuna.description import following, plausibility, reference
from hypertuna.description.reference import keys as list_keys
from hypertuna.description.robot import Robot
from hypertuna.description.schema.base import Part, Positive, Radio, Scale, Spread, entry
from hypertuna.description.schema.body import Fins, Spatial
from hypertuna.description.schema.control import Controller, Guidance
from hypertuna.description.schema.firmware import Firmware
from hypertuna.description.schema.hydraulics import Oil
from hypertuna.firmware import header, parameters
from hypertuna.firmware.parameters import EXTRA, TABLES, firmware_table
from hypertuna.simulation import estimates

TOP = Path(__file__).parents[2]
WHERE = ("src/hypertuna", "core/include", "bindings", "hosts", "firmware/app", "robots/hypertuna.toml")
DERIVED = {  # keys of which the core has something else under the same name, or that a result is named as
    *("fin_tilt", "pitch_max", "climb_max", "depth_rate"),
}


@cache
def sources() -> dict[str, str]:
    """Return the tracked sources of the package, core, hosts and firmware, and a robot."""
    found = subprocess.run(["git", "ls-files", *WHERE], cwd=TOP, capture_output=True, text=True, check=True)
    return {name: (TOP / name).read_text() for name in found.stdout.split() if name.endswith((".py", "pp", ".toml"))}


def naming(pattern: str, ending: str = "") -> list[str]:
    """Return the sources that have a pattern."""
    return [name for name, text in sources().items() if name.endswith(ending) and re.search(pattern, text)]


@pytest.mark.parametrize(
    ("table", "name", "most"),
    [
        *((Guidance, name, 4) for name in ("fix_timeout", "response_time", "pitch_damping", "compass_timeout")),
        *(
            (table, name, 5)
            for table, name in ((Fins, "drag_zero"), (Controller, "slew"), (Controller, "pressure_soft"))
        ),
        *((Firmware, name, 4) for name in ("home_timeout", "rise_depth")),
        *((table, name, 3) for table, name in ((Oil, "viscosity_40"), (Spatial, "inertia_pitch"))),
        *((Firmware, name, 3) for name in ("imu_serial", "radio_baud")),
    ],
)
def test_a_key_is_named_by_few_files(table: type[Part], name: str, most: int) -> None:
    """A pilot's key by 4: its declaration, its value, member and use in the core; without the core by 3."""
    files = naming(rf"\b({name}|{table.model_fields[name].alias})\b")
    assert len(files) in range(2, most + 1), files


class Longer(Guidance, table="guidance"):
    """A pilot's table with one key more, which has all that a key may declare."""

    extra: Positive = entry(
        "length of no meaning",
        "m",
        how="ruler",
        usual=(1.0, 2.0),
        radio=Radio(99),
        scale=Scale("as long as the robot", {"length": 1}),
        follows={"length": 2},
        spread=Spread(99, "extra length", 0.5, 2.0),
    )


class Other(Robot):
    """A robot with that table."""

    guidance: Longer | None = entry("table of the pilot on board", default=None)


def test_a_new_key_is_in_every_list(tuna: ht.Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    """With one line: documentation, checks, estimates, robots of other sizes, parameters of the radio, the studio."""
    document = tuna.document()
    robot = Other.model_validate(document | {"guidance": document["guidance"] | {"extra_m": 5.0}})
    for module in (reference, plausibility, estimates):
        monkeypatch.setattr(module, "Robot", Other)
    monkeypatch.setitem(TABLES, "pilot", Longer)
    monkeypatch.setitem(following.TABLES, "guidance", Longer)
    rows = {key.key: key for key in list_keys()}
    assert rows["guidance.extra_m"][1:] == ("m", "number > 0", "", "1 to 2", "ruler", "length of no meaning")
    assert "guidance.extra_m has 5 m; usual are 1 to 2" in " ".join(plausibility.implausible(robot))
    assert estimates.spreads(robot)["guidance.extra_m"].name == "extra length"
    assert Longer.scales("length", "mass").keys() - Guidance.scales("length", "mass").keys() == {"extra_m"}
    assert Longer.scaled(document["guidance"] | {"extra_m": 5.0}, length=0.5)["extra_m"] == 2.5
    assert ("pilot", "extra", Radio(99)) in parameters._settable()
    assert header.describe("pilot", "extra", "extra") == ("length of no meaning", "m")
    assert following.followers("length", 3, alias=True)["guidance.extra_m"] == 2


def test_limits_on_board_are_keys_of_the_firmware(tuna: ht.Robot) -> None:
    """Names and order are the firmware's own; a member without a key or a rule is refused."""
    limits = [name for part, name, _ in firmware_table(tuna).fields if part == "limits"]
    assert len(limits) == len(set(limits)) > 10
    assert set(limits) - Firmware.declared.keys() == {"sign"}
    columns = firmware_table(tuna)
    for name in limits:
        if name not in ("sign", "tilt_max"):
            assert columns.column(name) == pytest.approx([getattr(tuna.firmware, name)])


def test_no_list_repeats_the_keys_that_the_core_has(tuna: ht.Robot) -> None:
    assert tuna.guidance is not None
    names = given_constants("pilot", tuna.guidance).keys() - DERIVED
    assert len(names) > 30
    repeated = {name: naming(rf'["\']{name}["\']', ".py") for name in names}
    declared = "src/hypertuna/description/schema/control.py"  # its checks name keys
    assert {name: files for name, files in repeated.items() if set(files) - {declared}} == {}


def test_a_parameter_is_a_key_with_a_range_or_one_of_few_computed_ones(tuna: ht.Robot) -> None:
    table = firmware_table(tuna)
    parts = {
        part: {table.fields[p.field][1] for p in table.parameters if table.fields[p.field][0] == part}
        for part in TABLES
    }
    for part, columns in parts.items():
        declared = {name for name, key in TABLES[part].declared.items() if key.radio is not None}
        assert declared <= columns
        assert len(columns - declared) == 1  # amplitude, curvature, sign
        declared_places = [key.radio.place for key in TABLES[part].declared.values() if key.radio is not None]
        places = declared_places + [radio.place for radio in EXTRA[part].values()]
        assert len(set(places)) == len(places)
