"""Robots as FMUs: strangers' checkers accept them, and they swim as `ht.twin` does, to the last bit."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tomllib
from collections import Counter
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import fmpy
import lief
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from typer.testing import CliRunner

import hypertuna as ht
from fmu_unit import TICK, Unit
from hypertuna.actuation.new import first_robot
from hypertuna.cli.main import app
from hypertuna.description.robot import parse
from hypertuna.export import fmu as module

GAIT = ht.Gait.from_degrees(frequency=2, amplitude=(10, 15), phase=(0, 40))
COMMAND = {"frequency": GAIT.frequency, "armed": True} | {
    f"{kind}_{name}": value
    for kind in ("amplitude", "phase", "bias")
    for name, value in zip(("I", "II"), getattr(GAIT, kind), strict=True)
}
FORMS = [(kind, fmi, sea) for kind in ("twin", "plant") for fmi in (2, 3) for sea in (False, True)]


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[tuple[str, int, bool], Path]:
    """FMUs of HyperTuna in all forms."""
    folder = tmp_path_factory.mktemp("fmus")
    made = {form: folder / f"{form[0]}{form[1]}{form[2]}.fmu" for form in FORMS}
    for (kind, fmi, sea), path in made.items():
        path.write_bytes(ht.fmu("hypertuna", kind=kind, fmi=fmi, sea=sea))
    return made


@pytest.mark.parametrize("form", FORMS, ids=str)
def test_checkers_find_nothing(files: dict[tuple[str, int, bool], Path], form: tuple[str, int, bool]) -> None:
    assert validate_fmu(str(files[form])) == []
    again = ht.fmu("hypertuna", kind=form[0], fmi=form[1], sea=form[2])
    assert again == files[form].read_bytes()


@pytest.mark.parametrize("fmi", [2, 3])
def test_fmutool_finds_nothing(files: dict[tuple[str, int, bool], Path], fmi: int) -> None:
    line = [sys.executable, "-m", "fmu_manipulation_toolbox", "-input", str(files["twin", fmi, True]), "-check"]
    done = subprocess.run(line, capture_output=True, text=True, check=True)
    said = " ".join((done.stdout + done.stderr).split())
    assert f"No semantic error against the FMI-{fmi} standard." in said


@pytest.mark.parametrize("fmi", [2, 3])
def test_twin_swims_as_in_python(files: dict[tuple[str, int, bool], Path], fmi: int) -> None:
    """20 s with noise of the sensors: state at the same time, and what the last tick did."""
    run = ht.twin("hypertuna", GAIT, duration=20, seed=5)
    shown = ["x", "y", "heading", "speed", "angle_II", "pump_pressure_I_left", "power", "status"]
    rows = fmpy.simulate_fmu(
        str(files["twin", fmi, False]),
        stop_time=20,
        step_size=TICK,
        output_interval=TICK,
        start_values=COMMAND | {"seed": 5},
        output=shown,
    )
    for name in ("x", "y", "heading", "speed"):
        assert np.array_equal(rows[name][:-1], run.data[name]), name
    assert np.array_equal(rows["angle_II"][:-1], run.data["angle"][:, 1])
    assert np.array_equal(rows["pump_pressure_I_left"][:-1], run.data["pump_pressure"][:, 0])
    for name in ("power", "status"):
        assert np.array_equal(rows[name][1:], run.data[name]), name
    assert abs(run.data["x"][-1]) > 1


@pytest.mark.parametrize("fmi", [2, 3])
def test_twin_at_sea_swims_as_in_python(files: dict[tuple[str, int, bool], Path], fmi: int) -> None:
    sea = ht.Sea(current=(0.1, -0.05))
    fins = (-0.2, 0.1)
    run = ht.twin_at_sea("hypertuna", GAIT, duration=3, fins=fins, sea=sea, depth=3, heading=0.3, speed=0.2, seed=4)
    start = {"start_depth": 3.0, "start_heading": 0.3, "start_speed": 0.2, "current_east": 0.1, "current_north": -0.05}
    sides = {"fin_command_port": fins[0], "fin_command_starboard": fins[1]}
    unit = Unit(files["twin", fmi, True], **COMMAND, **start, **sides, seed=4)
    names = ("position_east", "position_north", "depth", "roll", "pitch", "heading")
    for k in range(len(run.time)):
        wanted = [*run.position[k, :2], run.depth[k], *run.angles[k]]
        assert unit.get(*names) == pytest.approx(wanted, rel=1e-9, abs=1e-9), k
        unit.step()
    unit.close()


@pytest.mark.parametrize("fmi", [2, 3])
def test_plant_under_the_pulses_of_a_run_repeats_it(files: dict[tuple[str, int, bool], Path], fmi: int) -> None:
    """Pulses of the robot's own controller from outside: the same motion, and the same readings of the sensors."""
    run = ht.twin("hypertuna", GAIT, duration=5, seed=5)
    unit = Unit(files["plant", fmi, False], seed=5)
    drives = [f"{name}".replace("-", "_") for name in run.drives]
    for k, pulses in enumerate(run.data["pulse"]):
        assert np.array_equal(unit.get("x", "y", "heading"), [run.data[n][k] for n in ("x", "y", "heading")]), k
        read = unit.get(*(f"pressure_read_{name}" for name in drives), "bend_read_I", "bend_read_II")
        assert np.array_equal(read, [*run.data["pressure_measured"][k], *run.data["angle_measured"][k]]), k
        unit.set(**{f"pulse_command_{name}": pulse for name, pulse in zip(drives, pulses, strict=False)})
        unit.step()
    unit.close()


@pytest.mark.parametrize("form", FORMS, ids=str)
def test_states_go_on_to_the_same_bits(files: dict[tuple[str, int, bool], Path], form: tuple[str, int, bool]) -> None:
    """Restored in the same instance, and from bytes in another one that has gone elsewhere.

    Saved within a tick, which goes on under the inputs that it began with, after they have changed.
    """
    start: dict[str, Any] = COMMAND if form[0] == "twin" else {"pulse_command_I_left": 0.0017}
    if form[0] == "twin" and form[2]:
        start = start | {"steered": True, "depth_command": 3.0, "heading_command": 1.0}
    unit, other = Unit(files[form], **start, seed=1), Unit(files[form], seed=2)
    shown = [name for name, one in unit.variables.items() if one.causality == "output"]
    word = "State" if form[1] == 3 else "state"
    unit.step(0.353)  # between two decisions of a pilot
    unit.set(**{name: 0.5 * value for name, value in start.items() if name in ("amplitude_I", "pulse_command_I_left")})
    unit.step(0.004)
    other.step(0.106)
    state = getattr(unit.unit, f"getFMU{word}")()
    serialize, deserialize = f"serializeFMU{word}", f"{'de' if form[1] == 3 else 'deS'}erializeFMU{word}"
    if form[1] == 3:
        deserialize = "deserializeFMUState"
    bytes_of = getattr(unit.unit, serialize)(state)
    before = unit.get(*shown)
    unit.step(0.2)
    first = unit.get(*shown)
    for one, given in ((unit, state), (other, getattr(other.unit, deserialize)(bytes_of))):
        getattr(one.unit, f"setFMU{word}")(given)
        one.time = 0.357
        assert np.array_equal(one.get(*shown), before, equal_nan=True)
        one.step(0.2)
        assert np.array_equal(one.get(*shown), first, equal_nan=True)
        getattr(one.unit, f"freeFMU{word}")(given)
        one.close()
    assert not np.array_equal(before, first)


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize(("interval", "stop"), [(1 / 60, 2.0), (0.01, 1.005), (0.0133, 1.0), (0.004, 0.2)])
def test_importers_may_step_as_they_like(
    files: dict[tuple[str, int, bool], Path], fmi: int, interval: float, stop: float
) -> None:
    """Outputs are those of the last control tick at or before each time, also at a stop time between two ticks."""
    run = ht.twin("hypertuna", GAIT, duration=2, seed=5)
    rows = fmpy.simulate_fmu(
        str(files["twin", fmi, False]),
        stop_time=stop,
        output_interval=interval,
        start_values=COMMAND | {"seed": 5},
        output=["x", "angle_II"],
    )
    times, wanted = rows["time"], np.append(run.data["x"], np.nan)
    assert times[-1] == stop
    ticks = np.floor(times / TICK + 1e-6).astype(int)
    here = ticks < len(run.data["x"])
    assert np.array_equal(rows["x"][here], wanted[ticks[here]])
    assert np.array_equal(rows["angle_II"][here], run.data["angle"][ticks[here], 1])
    assert here.sum() > 0.95 * len(times)
    assert len(set(ticks)) > 15


@pytest.mark.parametrize("summed", [False, True])
@pytest.mark.parametrize("fmi", [2, 3])
def test_times_do_not_drift(files: dict[tuple[str, int, bool], Path], fmi: int, summed: bool) -> None:
    """Five thousand steps of 1/60 s, multiplied or summed by the importer: at whole seconds, 100 ticks each."""
    unit, other = (Unit(files["twin", fmi, False], **COMMAND) for _ in range(2))
    for k in range(1, 5_001):
        unit.step(1 / 60, at=None if summed else (k - 1) / 60)
        if k in (1_000, 5_000):  # 1666 2/3 and 8333 1/3 ticks
            other.step((k * 100 // 60) * TICK - other.time)
            assert np.array_equal(unit.get("x", "y", "power"), other.get("x", "y", "power"))
            assert unit.get("time")[0] == pytest.approx(k / 60, abs=1e-9)
    assert unit.time / TICK % 1 == pytest.approx(1 / 3, abs=1e-6)
    for one in (unit, other):
        one.close()


@pytest.mark.parametrize("form", [("twin", 2, True), ("plant", 3, False)], ids=str)
def test_a_tick_takes_the_inputs_that_hold_when_it_begins(
    files: dict[tuple[str, int, bool], Path], form: tuple[str, int, bool]
) -> None:
    """Random steps with an input that changes at each: as steps of one tick, each with the input of its begin."""
    random, name = np.random.default_rng(3), "amplitude_I" if form[0] == "twin" else "pulse_command_I_left"
    low, high = (0.0, 0.3) if form[0] == "twin" else (0.0012, 0.0018)
    unit, other = (Unit(files[form], **(COMMAND if form[0] == "twin" else {})) for _ in range(2))
    shown = [one for one, about in unit.variables.items() if about.causality == "output"]
    times = [0.0]
    for _ in range(200):
        if random.random() < 0.2:  # at a tick
            times.append((np.floor(times[-1] / TICK) + random.integers(1, 4)) * TICK)
        else:
            times.append(times[-1] + random.choice([0.002, 0.016, 0.05]) * random.uniform(0.5, 1))
    values = random.uniform(low, high, len(times))
    seen = {}
    for at, until, value in zip(times[:-1], times[1:], values, strict=False):
        unit.set(**{name: value})
        unit.step(until - at, at=at)
        seen[int(until / TICK + 1e-6)] = unit.get(*shown)
    for tick in range(max(seen)):
        other.set(**{name: values[np.searchsorted(times, tick * TICK + 1e-9, side="right") - 1]})
        other.step(at=tick * TICK)
        if tick + 1 in seen:
            assert np.array_equal(other.get(*shown), seen[tick + 1], equal_nan=True), tick
    assert len(seen) > 100
    for one in (unit, other):
        one.close()


@pytest.mark.parametrize("fmi", [2, 3])
def test_steps_of_no_time_are_refused(files: dict[tuple[str, int, bool], Path], fmi: int) -> None:
    """With an error, so that importers end: FMPy repeats a step that is discarded."""
    unit = Unit(files["twin", fmi, False], **COMMAND)
    for size in (0.0, -0.01, float("nan"), float("inf"), 1e8):
        with pytest.raises(Exception, match=r"oStep failed with status 3"):
            unit.step(size, at=0)
        assert "s, but must be above 0 and at most 10000000 s" in unit.said.pop()
    with pytest.raises(Exception, match=r"oStep failed with status 3"):
        unit.step(at=0.5)
    assert unit.said.pop() == "step: begins at 0.5 s, but the last one ended at 0 s"
    unit.time = 0.0
    unit.step(0.3)
    assert unit.get("time")[0] == pytest.approx(0.3)
    with pytest.raises(Exception, match="etFloat64|etReal"):
        unit.set(start_speed=0.1)
    assert "is fixed" in unit.said.pop()
    with pytest.raises(Exception, match="etFloat64|etReal"):
        unit.set(frequency=float("nan"))
    assert "must be a finite number" in unit.said.pop()
    unit.close()


@pytest.mark.parametrize("fmi", [2, 3])
def test_reset_begins_again(files: dict[tuple[str, int, bool], Path], fmi: int) -> None:
    unit = Unit(files["twin", fmi, False], **COMMAND, seed=3)
    unit.step(1.0)
    first = unit.get("x", "y", "power")
    unit.unit.reset()
    unit.set(**COMMAND, seed=3)
    if fmi == 2:
        unit.unit.setupExperiment(startTime=0.0)
    unit.unit.enterInitializationMode()
    unit.unit.exitInitializationMode()
    unit.time = 0.0
    for _ in range(10):
        unit.step(0.1)
    assert np.array_equal(unit.get("x", "y", "power"), first)
    unit.close()


def test_binaries_that_are_older_than_their_sources_are_not_packed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As after a change of the core, until `make fmu` has run; a wheel has no sources."""
    built, source = tmp_path / "build/x86_64-linux/fmi2.so", tmp_path / "core.hpp"
    built.parent.mkdir(parents=True)
    for file, age in ((built, 1000), (source, 2000)):
        file.write_bytes(b"")
        os.utime(file, (age, age))
    monkeypatch.setattr(module, "BINARIES", str(tmp_path / "build"))
    monkeypatch.setattr(module, "_sources", lambda: iter([source]))
    with pytest.raises(
        ht.InputError, match=r"fmi2.so must not be older than .*: run `make fmu FMU_PLATFORMS='x86_64-li"
    ):
        module.fmu_binaries(2)
    os.utime(built, (2000, 2000))
    assert list(module.fmu_binaries(2)) == ["x86_64-linux"]
    monkeypatch.undo()
    assert {path.name for path in module._sources()} >= {"fmu.hpp", "device.h", "simulate.hpp", "fmi2.cpp"}


MACHINES = {  # magic bytes, and the machine's place and bytes
    "x86_64-linux": (b"\x7fELF", 18, b"\x3e\x00"),
    "aarch64-linux": (b"\x7fELF", 18, b"\xb7\x00"),
    "x86_64-windows": (b"MZ", None, b"PE\0\0\x64\x86"),
    "x86_64-darwin": (b"\xcf\xfa\xed\xfe", 4, b"\x07\x00\x00\x01"),
    "aarch64-darwin": (b"\xcf\xfa\xed\xfe", 4, b"\x0c\x00\x00\x01"),
}


@pytest.mark.parametrize("fmi", [2, 3])
def test_binaries_are_of_their_machines_and_export_the_functions_of_the_standard_alone(fmi: int) -> None:
    """Binaries of other machines do not run here: their heads and what they export are checked.

    That is what the standard's header has, for FMI 2.0 without model exchange.
    """
    header = (Path(fmpy.__file__).parent / f"c-code/fmi{fmi}Functions.h").read_text()
    header = re.sub(
        r"Functions for FMI2 for Model Exchange.*?Functions for FMI2 for Co-Simulation", "", header, flags=re.S
    )
    standard = set(re.findall(rf"\bfmi{fmi}\w+(?=;)", header))
    assert len(standard) == {2: 34, 3: 75}[fmi]
    for platform, path in module.fmu_binaries(fmi).items():
        content = path.read_bytes()
        magic, place, machine = MACHINES[platform]
        assert content.startswith(magic)
        at = int.from_bytes(content[60:64], "little") if place is None else place
        assert content[at:].startswith(machine)
        exported = {function.name for function in lief.parse(path).exported_functions}
        if platform.endswith("darwin"):  # whose linker in ziglang exports its own symbols and the library's allocation
            exported = {
                name[1:] for name in exported if not re.match(r"__Z(nw|na|dl|da)|__(_dso_handle|mh_dylib_header)", name)
            }
        assert exported == standard, platform


def test_command_writes_a_file_and_names_its_platforms(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "fish.fmu"
    done = CliRunner().invoke(app, ["export", "fmu", "--robot", "hypertuna", "--fmi", "3", "-o", str(file)])
    assert done.exit_code == 0
    assert "x86_64-linux" in done.output
    assert "binaries/x86_64-linux/hypertuna_twin.so" in ZipFile(file).namelist()
    monkeypatch.setattr(module, "BINARIES", "build/no")
    with pytest.raises(ht.InputError, match="make fmu"):
        ht.fmu("hypertuna")
    with pytest.raises(ht.InputError, match="controller"):
        ht.fmu("examples/myfish.toml")


def test_robots_with_servos_on_their_axles_have_one_pulse_a_joint(tmp_path: Path) -> None:
    fish, path = ht.load("examples/servofish.toml"), tmp_path / "plant.fmu"
    path.write_bytes(ht.fmu(fish, kind="plant"))
    unit = Unit(path)
    unit.step(0.1)
    inputs = [name for name, one in unit.variables.items() if one.causality == "input"]
    assert inputs == [f"pulse_command_{group.name}" for group in fish.joints]
    unit.close()


@pytest.mark.parametrize("tail", ["passive", "flexible"])
def test_a_twin_tells_how_its_hinges_bend(tail: str, tmp_path: Path) -> None:
    fish, path = parse(tomllib.loads(first_robot("x", tail=tail, actuation="servo"))), tmp_path / "twin.fmu"
    path.write_bytes(ht.fmu(fish))
    run = ht.twin(fish, ht.Gait(1.0, (0.3,), (0.0,)), duration=1, seed=5)
    unit = Unit(path, frequency=1.0, amplitude_J1=0.3, phase_J1=0.0, bias_J1=0.0, armed=True, seed=5)
    for k in range(len(run.time)):
        for d, name in enumerate(run.hinges):
            shown = unit.get(*(f"hinge_{what}_{name.replace(' ', '_')}" for what in ("angle", "rate")))
            assert list(shown) == [run.data["hinge_angle"][k, d], run.data["hinge_rate"][k, d]]
        unit.step()
    unit.close()
    assert np.degrees(np.ptp(run.data["hinge_angle"], axis=0)).min() > 2


def test_units_are_products_of_base_units() -> None:
    """By the definitions of newton, pascal, watt, coulomb, volt and hertz; FMI writes N.m and m/s2."""
    base = {"s": "s", "m": "m", "rad": "rad", "A": "A", "Hz": "s-1", "N": "kg m s-2", "Pa": "kg m-1 s-2"}
    base |= {"W": "kg m2 s-3", "C": "A s", "V": "kg m2 s-3 A-1", "J": "kg m2 s-2", "K": "K", "kg": "kg"}
    for unit, (name, exponents) in module.UNITS.items():
        assert name == unit.replace("^", "").replace(" ", ".")
        found: Counter[str] = Counter()
        for part, sign in zip(unit.split("/"), (1, -1), strict=False):
            for factor in part.split():
                symbol, _, power = factor.partition("^")
                for letters, number in re.findall(r"([A-Za-z]+)(-?\d*)", base[symbol]):
                    found[letters] += sign * int(power or 1) * int(number or 1)
        assert found == exponents, unit
