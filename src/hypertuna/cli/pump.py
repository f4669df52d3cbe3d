"""The command `hypertuna pump`."""

import math
from collections.abc import Iterator, Sequence
from typing import Annotated, Any

from hypertuna.actuation.hydraulics import circuits
from hypertuna.actuation.sizing import REACHED, Size, Sizes, largest_beat, size_over
from hypertuna.cli import options as opt
from hypertuna.cli import parsing
from hypertuna.cli.console import progress_bar, table
from hypertuna.cli.emit import emit
from hypertuna.cli.twin import kelvin
from hypertuna.description.provenance import provenance
from hypertuna.description.robot import Robot
from hypertuna.io.files import dataset
from hypertuna.io.quantity import ZERO_CELSIUS, column_units, counted, label, listed, suffix
from hypertuna.ranges import Whole
from hypertuna.swimming.gait import named_gait

CASES = Whole(max=10_000)
LIMITS = {
    "pressure": "the pressure limit",
    "suction": "suction",
    "servo": "a servo that lags by speed, torque or bandwidth",
    "compliance": "compliance of lines, oil and air",
    "line": "the oil line, which lags",
}
LETTERS = {"pressure": "p", "suction": "s", "servo": "v", "compliance": "c", "line": "l"}
TURBULENT = "turbulent: the pressure drop is underestimated"  # of a line beyond the laminar law


def _over(text: str, key: str) -> tuple[str, list[float]]:
    """Read KEY=VALUES."""
    name, values = parsing.pair(text, key, "KEY=VALUE,...")
    return name, parsing.values(values, f"{key} {name}", "the unit of the key")


@opt.grouped
def pump_command(
    robot: opt.RobotOptions,
    gait: opt.GaitName = None,
    frequency: Annotated[
        Sequence[float] | None, opt.values("--frequency", "Hz", f"Beat frequency: {opt.RANGE}. (default: the highest)")
    ] = None,
    amplitude: Annotated[
        Sequence[float] | None,
        opt.numbers("--amplitude", "degrees", "Amplitudes, one per joint group. (default: the largest)"),
    ] = None,
    bore: Annotated[
        Sequence[float] | None,
        opt.values("--bore", "mm", f"Inner diameter of all lines: {opt.RANGE}. {opt.ROBOTS}", limits=opt.BORES),
    ] = None,
    temperature: Annotated[
        Sequence[float] | None,
        opt.values("--temperature", "C", f"Oil temperature: {opt.RANGE}. {opt.ROBOTS}"),
    ] = None,
    over: Annotated[
        list[Any] | None,
        opt.option(
            ("--over",),
            f"Key of the robot's file and its {opt.RANGE}, such as joints.I.actuator.lever_m=0.008:0.012:3 or "
            '"servos.piston pump.torque_n_m=3:7:3"; repeatable.',
            "KEY=VALUE,...",
            _over,
        ),
    ] = None,
    files: opt.Files = opt.NO_FILES,
) -> None:
    """Size the pump: torque, speed and stroke of its servos, drop and bandwidth of the lines.

    Each joint beats alone, in air and without mass: what hydraulics alone can do. Without a gait, frequency and
    amplitude are the largest possible.
    """
    fish = robot.load()
    circuits(fish)  # checks the tables of the file
    frequencies, amplitudes = _beat(fish, gait, frequency, amplitude)
    bores: list[float | None] = [None] if bore is None else [1e-3 * value for value in bore]
    temperatures = [None] if temperature is None else [kelvin(value) for value in temperature]
    axes = [*(values for _, values in over or []), frequencies, bores, temperatures]
    CASES.check(math.prod(map(len, axes)), "the number of cases", "take fewer values: each case takes about 0.1 s")
    with progress_bar("sizing") as progress:
        sizes = size_over(
            fish,
            dict(over or []),
            frequency=frequencies,
            amplitude=amplitudes,
            bore=bores,
            temperature=temperatures,
            progress=progress,
        )
    emit(
        sizes,
        record=lambda sizes: provenance(fish) | {"sizes": [size.record() for size in sizes]},
        lines=lambda sizes: _lines(fish, sizes),
        dataset=lambda sizes: _dataset(fish, sizes),
        columns=[*sizes[0].record()],
        digits=None,
        figure=lambda sizes: Sizes(sizes).plot(),
        **vars(files),
    )


def _beat(
    robot: Robot, gait: str | None, frequency: Sequence[float] | None, amplitude: Sequence[float] | None
) -> tuple[list[float], tuple[float, ...]]:
    """Return frequencies [Hz] and amplitudes [rad]: as given, else of a named gait, else the largest."""
    if gait is not None:
        named = named_gait(robot, gait)
        fastest, largest = named.frequency, tuple(named.amplitude)
    else:
        fastest, largest = largest_beat(robot) if frequency is None or amplitude is None else (0.0, ())
    angles = largest if amplitude is None else tuple(math.radians(angle) for angle in amplitude)
    return [fastest] if frequency is None else list(frequency), angles


def _limits(size: Size) -> tuple[str, ...]:
    """Name what costs bend: at the pressure limit, a faster servo would not help."""
    return tuple(name for name in size.limits if name != "servo" or "pressure" not in size.limits)


def _dataset(robot: Robot, sizes: list[Size]) -> Any:
    """Return a variable per column, along the cases."""
    rows = [size.record() | {"turbulent": int(size.turbulent), "limits": " ".join(size.limits)} for size in sizes]
    units = column_units(Size)

    def column(name: str) -> tuple[str, list[Any], dict[str, str]]:
        unit = units.get(name, "W" if name.endswith("_w") else "")
        about = {"units": unit} if unit else {}
        return "case", [row[name] for row in rows], about | {"long_name": label(name.removesuffix(suffix(unit)))}

    return dataset({name: column(name) for name in rows[0]}, {}, provenance(robot))


def _lines(robot: Robot, sizes: list[Size]) -> Iterator[Any]:
    """Lay out the servos of each joint, then one case in full, or a table over bore and temperature."""
    yield f"{robot.name}: the pump's servos, the lines, and the bend reached in air", "bold"
    if sizes[0].values:
        yield from _over_lines(sizes)
        return
    beats: dict[tuple[str, float], list[Size]] = {}
    for size in sizes:
        beats.setdefault((size.joint, size.frequency), []).append(size)
    for cases in beats.values():
        yield from _servo_lines(cases[0])
        if len(cases) == 1:
            yield from _case_lines(cases[0])
        else:
            yield _case_table(cases)
    if len(sizes) > len(beats):
        yield f"bend reached [deg] (corner of the line [Hz]); limits: {_legend(sizes)}"


def _letters(size: Size) -> str:
    """Write the limits of a case in letters."""
    return "".join(LETTERS[name] for name in _limits(size)) + "t" * size.turbulent


def _legend(sizes: list[Size]) -> str:
    """Explain the letters of these cases."""
    used = "".join(map(_letters, sizes))
    meanings = {letter: LIMITS[name] for name, letter in LETTERS.items()} | {"t": TURBULENT}
    return "; ".join(f"{letter} {text}" for letter, text in meanings.items() if letter in used) or "none"


def _over_lines(sizes: list[Size]) -> Iterator[Any]:
    """Lay out a table with a row for each case of the keys that vary."""
    bores, temperatures = ({getattr(size, name) for size in sizes} for name in ("bore", "temperature"))
    yield f"over {listed([*sizes[0].values])}", "dim"
    heads = ["\njoint", "f\n[Hz]", *(f"\n{key.rpartition('.')[2]}" for key in sizes[0].values)]
    heads += ["bore\n[mm]"] * (len(bores) > 1) + ["oil\n[C]"] * (len(temperatures) > 1)
    heads += [
        "bend\n[deg]",
        "of\n[deg]",
        "torque\nof limit",
        "servo speed\nof limit",
        "stroke\nof limit",
        "power\n[W]",
        "\nlimits",
    ]
    rows = []
    for size in sizes:
        row = [size.joint, f"{size.frequency:.3g}", *(f"{value:.4g}" for value in size.values.values())]
        row += [f"{1e3 * size.bore:.3g}"] * (len(bores) > 1)
        row += [f"{size.temperature - ZERO_CELSIUS:.3g}"] * (len(temperatures) > 1)
        loads = (
            size.torque / size.torque_limit,
            size.servo_speed / size.servo_speed_limit,
            size.stroke / size.stroke_limit,
        )
        row += [
            f"{math.degrees(size.bend):.1f}",
            f"{math.degrees(size.command):.3g}",
            *(f"{100 * load:.0f} %" for load in loads),
        ]
        rows.append([*row, f"{size.electrical_power['total']:.3g}", _letters(size) or "none"])
    yield table(heads, rows, left=(0, len(heads) - 1))
    yield f"limits: {_legend(sizes)}"
    if any(size.torque > size.torque_limit for size in sizes):
        yield "torque above 100 %: the servo stalls below the pressure limit"
    yield _verdict(sizes), "bold"


def _verdict(sizes: list[Size]) -> str:
    """Name the smallest values with which all joints reach their bend in all beats, or the best ones."""
    cases: dict[tuple[float, ...], list[Size]] = {}
    for size in sizes:
        cases.setdefault(tuple(size.values.values()), []).append(size)
    asked = f"{100 * REACHED:g} % of the commanded bend with enough torque for the pressure limit"
    good = sorted(values for values, own in cases.items() if all(size.reached for size in own))
    if good:
        return (
            f"{len(good)} of {counted(len(cases), 'case')} reach {asked}; the smallest has {_values(sizes, good[0])}."
        )
    best = max(cases, key=lambda values: min(size.bend / size.command for size in cases[values]))
    share = min(size.bend / size.command for size in cases[best])
    return f"No case reaches {asked}; the best one reaches {100 * share:.0f} %, with {_values(sizes, best)}."


def _values(sizes: list[Size], values: Sequence[float]) -> str:
    """Write the values of the keys that vary."""
    return listed([f"{key} = {value:.4g}" for key, value in zip(sizes[0].values, values, strict=True)])


def _servo_lines(size: Size) -> Iterator[Any]:
    """Lay out what a beat needs of a servo, beside what the servo has."""
    record = size.record()
    left = size.servo_speed_limit * max(0.0, 1 - size.torque / size.torque_limit)
    beat = f"joint {size.joint} at {size.frequency:.3g} Hz, {record['command_deg']:.3g} deg commanded"
    yield f"{beat}; a servo needs, and has", "bold"
    yield f"  torque, at the pressure limit {size.torque:8.3g} of {size.torque_limit:.3g} N m"
    speed = f"{size.servo_speed:8.3g} of {size.servo_speed_limit:.3g} rad/s, {left:.3g} at that torque"
    yield f"  servo speed                   {speed}"
    yield f"  stroke                        {record['stroke_deg']:8.3g} of {record['stroke_limit_deg']:.3g} deg"


def _case_lines(size: Size) -> Iterator[str]:
    """Lay out all of one case."""
    record = size.record()
    shares = ", ".join(f"{name} {watts:.2g}" for name, watts in size.electrical_power.items() if name != "total")
    turbulent = f", {TURBULENT}" if size.turbulent else ""
    rows = {
        "oil": f"{record['temperature_c']:.3g} C, {record['viscosity_mm2_s']:.4g} mm^2/s",
        "line": f"{record['bore_mm']:.3g} mm, Reynolds number {size.reynolds:.3g}{turbulent}",
        "pressure drop, along the line": f"{record['pressure_drop_kpa']:.3g} kPa for the whole bend",
        "corner, of the line": f"{size.corner:.3g} Hz, for small motions {size.corner_rest:.3g} Hz",
        "resonance, with the muscles": f"{size.resonance:.3g} Hz, damping ratio {size.damping_ratio:.2g}",
        "ring, with the cylinder": f"{size.ring:.3g} Hz, damping ratio {size.ring_damping_ratio:.2g}",
        "bend, reached": f"{record['bend_deg']:.3g} deg, {record['lag_deg']:.3g} deg late",
        "command fraction": f"{100 * size.command_fraction:.3g} % of the whole",
        "max pressure, of cylinders": f"{record['pressure_max_kpa']:.0f} kPa; min {record['pressure_min_kpa']:.0f} kPa",
        "limited by": "; ".join(LIMITS[name] for name in _limits(size)) or "nothing",
        "electrical power, both servos": f"{size.electrical_power['total']:.3g} W: {shares}",
    }
    for name, text in rows.items():
        yield f"  {name:30}{text}"


def _case_table(cases: list[Size]) -> Any:
    """Lay out the bend reached over bore and temperature."""
    temperatures = list(dict.fromkeys(size.temperature for size in cases))
    bores = list(dict.fromkeys(size.bore for size in cases))
    known = {(size.bore, size.temperature): size for size in cases}
    heads = ["  bore [mm]"]
    for temperature in temperatures:
        viscosity = known[bores[0], temperature].viscosity * 1e6
        heads.append(f"{temperature - ZERO_CELSIUS:.3g} C\n{viscosity:.3g} mm^2/s")
    rows = ((f"{bore * 1e3:.3g}", *(_cell(known[bore, t]) for t in temperatures)) for bore in bores)
    return table(heads, rows, left=())


def _cell(size: Size) -> str:
    """Write a case in a few letters."""
    return f"{math.degrees(size.bend):.1f}{_letters(size)} ({size.corner:.2g})"
