"""Tables and picture of docs/howto/bring-up.md; docs/figures.py includes them."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache

import numpy as np
from figures_common import FISH, rows
from matplotlib.figure import Figure

import hypertuna as ht
from hypertuna import _core
from hypertuna.actuation.battery import range_of
from hypertuna.control.guidance import pilot_columns
from hypertuna.firmware.parameters import firmware_table
from hypertuna.firmware.plots import plot_wiring
from hypertuna.firmware.wiring import SUPPLY, wiring_of

KG_CM = 0.0980665  # N m in 1 kg cm
FIRST, SECOND = "unoptimised-0.3", "unoptimised-0.4"  # the slowest gaits of the file
FRESH, SEA = 998.2, 1025.0  # densities of fresh and of sea water [kg/m^3]
OURS, PAPER = "ours", "paper, Table I"  # sources of parts
PRESSURE = next(sensor for sensor in FISH.sensors if sensor.quantity == "pressure")

# What a maker does about each fault, and about each refusal, that the firmware knows.
FAULT_REMEDIES = {
    "over_pressure": "Disarm. Look for a blocked line or joint, and calibrate the pressure sensor.",
    "bend_sensor": "Check wire and divider of the sensor; then calibrate it.",
    "pressure_sensor": f"Check wire and 5 V supply. A pressure below {PRESSURE.low / 1e3:g} kPa or above "
    f"{PRESSURE.high / 1e3:g} kPa raises this fault, too.",
    "current_sensor": "Check wire and 5 V supply. The robot swims without it.",
    "imu": "Check wires, 115,200 bit/s, and that the IMU sends acceleration, rate and field.",
    "battery_sensor": "Check the divider and `voltage_pin`.",
    "low_battery": "Charge the battery. If a meter disagrees, calibrate `voltage`.",
    "empty_battery": "Charge the battery before the next dive.",
    "link_lost": "Come nearer; lift the antenna; check that the ground station sends heartbeats.",
    "link_gone": "As for `link_lost`. To call off the way home, arm the robot again.",
    "tilt": "Trim the robot, and check the axes of the IMU.",
    "no_progress": "Free the robot of what holds it. In a current as fast as it swims, wait or choose a faster gait.",
    "no_stroke": "Look for lost oil, a servo that stands, and what holds the joint; then fill and bleed its circuits.",
    "unguarded": "Check IMU and battery sensor before you swim by hand again.",
    "sinks": "Trim the robot until it floats by itself, and let it float for 20 s before you arm it.",
    "leak": "Lift the robot out, open it, dry it, and find the leak before the next dive.",
    "watchdog": "Read the black box, and replace the part that blocks the board.",
    "overrun": "Look for a part that answers slowly, and report the fault with the black box.",
    "defaults": "Calibrate again: this firmware has other parameters than those stored.",
    "memory": "Set the parameter again. If it happens twice, replace the board.",
    "black_box": "Use a faster card, formatted as FAT32.",
    "key_lost": "Delete the key with the recovery pin, and set a new one.",
    "depth_sensor": "Check the wires of its bus, their resistors and its 3.3 V.",
    "too_deep": "Trim the robot; check the mission's depths.",
}
REFUSAL_REMEDIES = {  # what to do about a refused command, by its reason
    "armed": "Disarm, then repeat the command.",
    "disarmed": "Arm first.",
    "out_of_range": "`hypertuna firmware params` lists the ranges.",
    "inconsistent": "Change the other parameter first, such as the soft limit before the hard one.",
    "unknown": "Check the name. Use the same version for firmware and ground station.",
    "not_ready": "Hold the robot still for some seconds; check the compass.",
    "faulty": "Read the faults: `hypertuna radio check`.",
    "busy": "Wait two seconds. `hypertuna` repeats the command by itself.",
    "no_mission": "Send one: `hypertuna radio mission`.",
    "too_many": "Shorten the mission.",
    "replayed": "Repeat the command, and give each ground station its own id.",
    "not_signed": "Give the key: `--key FILE`.",
    "elsewhere": "Clear the mission, or upload it again here.",
    "bad_fence": "Draw the fence without crossing sides.",
    "outside_fence": "Move the waypoint at least 3 m inside the fence (`fence_margin`), or home inside it.",
    "leaves_fence": "Add a waypoint, so that each leg stays inside the fence.",
    "robot_outside": "Carry the robot into the fence, or draw a larger one.",
    "too_deep": "Set the depth limit at least 30 cm below the deepest waypoint and 50 cm below the surface.",
    "not_now": "Select the mode first, such as `manual` for the sticks.",
    "other_pilot": "Take control by arming, or by selecting a mode.",
    "no_depth": "Bring the robot to the surface: `hypertuna radio calibrate --sensor depth`.",
    "not_centered": "Let go of all sticks, or press `x`.",
    "not_placed": "Wait for a fix, under open sky.",
    "by_program": "Run `hypertuna radio calibrate`, which asks for each position.",
    "one_fence": "Draw one polygon or one circle.",
    "no_rally": "Leave rally points out.",
    "too_fast": "Lower the speed of the leg.",
    "not_taken": "Leave out take-off, landing and loiter. The robot begins where it is armed.",
    "way_home": "Move the way home to the end of the list.",
    "too_small": "Enlarge the radius of the waypoint or of home: `hypertuna` asks for 1.9 m.",
    "int_only": "Send `COMMAND_INT`, or set param1 to 1 for home here.",
    "submerged": "Lift the robot to the surface. If it is already there, as after a drive down a mountain, restart it.",
    "bad_frame": "Give the item's place in degrees, or in m from the origin (`MAV_FRAME_LOCAL_NED`).",
    "far_origin": "Set an origin near this water, or none: the first fix sets one.",
}


@cache
def run(gait: str, medium: str) -> ht.TwinRun:
    """Run a gait on the twin, in water or in air."""
    return ht.twin(FISH, gait, duration=20, medium=medium)


def parts_table() -> str:
    """Tabulate the bill of materials."""
    wiring, battery = wiring_of(FISH), FISH.battery
    assert battery is not None
    names = [wire.part for wire in wiring.wires]
    count = {key: sum(key in name for name in names) for key in ("ACS712", "Flex", "XGZP6858A")}
    torque = {servos.drives: servos for servos in FISH.servos}
    pump, fins = torque["piston pump"], torque["pectoral fins"]
    lines = [
        ("Teensy 4.1, with a microSD card (FAT32)", 1, "control at 100 Hz, black box", PAPER),
        (f"servo, {pump.torque / KG_CM:.0f} kg cm", pump.count, "piston pump", PAPER),
        (f"servo, {fins.torque / KG_CM:.2f} kg cm", fins.count, "pectoral fins", PAPER),
        ("JY931", 1, "angular rate, acceleration, magnetic field", PAPER),
        ("Flex sensor 4.5", count["Flex"], "bend of a joint", PAPER),
        ("XGZP6858A", count["XGZP6858A"], "oil pressure of a cylinder", PAPER),
        ("ACS712 5A", count["ACS712"], "current of a pump servo", PAPER + ", which has two"),
        ("ATK-LORA, 433 MHz, and a second one ashore", 2, "radio", PAPER),
        (
            f"Li-ion 18650, {battery.capacity / 3.6:,.0f} mAh",
            battery.cells,
            f"battery, {battery.series} in series",
            PAPER + "; in series: ours",
        ),
        ("hydraulic oil L-HM46", 1, "about 0.2 L with spills (estimate)", "paper, section II.B"),
        ("MS5837-30BA", 1, "depth", OURS),
        ("NEO-M8N with antenna", 1, "position at the surface", OURS),
        ("leak probe: two bare wires 2 mm apart at the lowest point", 1, "water in the hull", OURS),
        ("three resistors (section 2)", 1, "battery voltage", OURS),
        (f"step-down converter to {battery.converter:.1f} V, and one to 5 V", 2, "servos; board and sensors", OURS),
        ("fuse, 10 A, slow; main switch", 1, "battery", OURS),
        ("level shifter, 3.3 to 5 V, 6 channels", 1, "servos that do not accept 3.3 V", OURS),
    ]  # fmt: skip
    return rows(["part", "number", "for", "source"], [[p, str(n), f, s] for p, n, f, s in lines], 4)


def wiring_table() -> str:
    """Tabulate the wiring."""
    body = []
    for w in wiring_of(FISH).wires:
        bus = f"{w.bus}, {w.rate:,} bit/s" if w.rate else w.bus
        signal = w.signal if "part" in w.signal else f"`{w.signal}`"
        level = f"{w.level}: {w.range}" if w.range else w.level
        body.append([f"{w.pin}", w.part, signal, bus, level])
    return rows(["pin", "part", "signal", "bus", "level at the pin"], body, 5)


def divider_table() -> str:
    """Tabulate the divider of the battery's voltage."""
    wiring, battery = wiring_of(FISH), FISH.battery
    assert battery is not None
    upper, lower, lift = (f"{ohm / 1e3:g} kΩ" for ohm in wiring.divider)
    body = [["battery to pin", upper], ["pin to ground", lower], ["pin to 3.3 V", lift]]
    for text, volts in (
        ("0 V", 0.0),
        (f"{battery.series * battery.charged:.1f} V, charged", battery.series * battery.charged),
        ("20 V", 20.0),
    ):
        body.append([f"pin at {text}", f"{wiring.divider.volts(volts):.2f} V"])
    assert wiring.divider.volts(20) < SUPPLY
    return rows(["from ... to", "value"], body)


def power_table() -> str:
    """Tabulate the currents that fuse, converter and wires must carry."""
    battery, pump = FISH.battery, next(s for s in FISH.servos if s.drives == "piston pump")
    assert battery is not None
    assert pump.stall_current is not None
    hard = run("unoptimised-max", "water")
    peak = float(hard.data["electrical_power"].sum(axis=1).max())
    low = FISH.controller.voltage_low  # type: ignore[union-attr]
    stalled = pump.count * pump.stall_current * battery.converter / battery.efficiency
    body = [
        ["first gait", f"{run(FIRST, 'water').electrical_power:.1f}"],
        ["fastest gait, mean", f"{hard.electrical_power:.1f}"],
        ["fastest gait, maximum", f"{peak:.1f}"],
        ["all pump servos stalled", f"{stalled:.0f}"],
    ]
    return rows(
        ["load", "power [W]", f"battery at {low:.1f} V [A]"], [[*line, f"{float(line[1]) / low:.1f}"] for line in body]
    )


def first_table() -> str:
    """Tabulate the twin's numbers of the first beats, in air and in water."""
    runs = [(gait, medium, run(gait, medium)) for gait in (FIRST, SECOND) for medium in ("air", "water")]
    lines: dict[str, list[str]] = {"": [f"in {medium}" for _, medium, _ in runs]}
    lines["frequency [Hz]"] = [f"{one.gait.frequency:g}" for *_, one in runs]
    lines["speed [m/s]"] = ["" if medium == "air" else f"{one.speed:.2f}" for _, medium, one in runs]
    lines["time of 5 m [s]"] = ["" if medium == "air" else f"{5 / one.speed:.0f}" for _, medium, one in runs]
    for k, group in enumerate(FISH.joints):
        lines[f"bend of joint {group.name} [deg]"] = [f"{math.degrees(one.swing[k]):.0f}" for *_, one in runs]
    lines["pressure, minimum [kPa]"] = [f"{one.pressure_min.min() / 1e3:.0f}" for *_, one in runs]
    lines["pressure, maximum [kPa]"] = [f"{one.pressure_max.max() / 1e3:.0f}" for *_, one in runs]
    lines["current of a servo, maximum [A]"] = [f"{one.data['current'].max():.1f}" for *_, one in runs]
    lines["power of all servos [W]"] = [f"{one.electrical_power:.1f}" for *_, one in runs]
    lines["one battery lasts [h]"] = [
        "" if medium == "air" else f"{range_of(FISH, power=one.electrical_power, speed=one.speed).endurance / 3600:.1f}"
        for _, medium, one in runs
    ]
    keys = [1 + list(FISH.gaits).index(gait) for gait, _, _ in runs]  # of `radio drive`
    heads = [f"key {key}: `{gait}`" for key, (gait, _, _) in zip(keys, runs, strict=True)]
    return rows(["", *heads], [[name, *cells] for name, cells in lines.items()])


def direction_table() -> str:
    """Tabulate a check of signs: a command or a motion, and the reading that must change with it."""
    bias = np.degrees(pilot_columns(FISH)["bias_max"])
    full = ht.Gait.from_degrees(frequency=1, amplitude=(0.5, 0.5), phase=(0, 0), bias=tuple(bias))
    steered = ht.twin(FISH, full, duration=8, medium="air")
    left, right = ((steered.pressure_max + steered.pressure_min)[k::2].mean() / 2e3 for k in (0, 1))
    assert left > right
    fins = math.degrees(pilot_columns(FISH)["fin_angle_max"][0])
    body = [
        [
            "`d` five times",
            "the tail fin moves to starboard",
            f"`bend` {bias[0]:+.0f} and {bias[1]:+.0f} deg; pressures left {left:.0f}, right {right:.0f} kPa",
        ],
        [
            "`a` ten times",
            "the tail fin moves to port",
            f"`bend` {-bias[0]:+.0f} and {-bias[1]:+.0f} deg; left and right pressures exchanged",
        ],
        [
            "`x`, then `r` five times",
            f"the leading edges of both fins rise, {fins:.0f} deg at most",
            "",
        ],
        ["`f` ten times", "the leading edges of both fins sink", ""],
        ["lift the nose by hand", "", "pitch grows"],
        ["roll it to starboard by hand", "", "roll grows"],
        ["turn it clockwise, seen from above", "", "heading grows: 0 north, 90 deg east"],
        ["lower it into a bucket", "", "depth grows"],
    ]
    return rows(["do", "the robot", "the screen"], body, 3)


def trim_table() -> str:
    """Tabulate the ballast that keeps a robot of this mass in balance in other water."""
    mass = FISH.body.mass
    waters = (("fresh water, 20 °C", FRESH), ("brackish water", 1010.0), ("sea water", SEA))
    body = [[text, f"{density:.0f}", f"{mass * density / FRESH:.2f}", f"{1e3 * mass * (density / FRESH - 1):+.0f}"]
            for text, density in waters]  # fmt: skip
    return rows(["water", "density [kg/m³]", "mass in balance [kg]", "ballast against fresh water [g]"], body)


def rise_table() -> str:
    """Tabulate how long a robot lighter than its water takes to the surface, lying level: drag across its links."""
    spatial, length = FISH.spatial, np.array(FISH.links.length)
    assert spatial is not None
    area = float(np.sum(np.array(spatial.drag_vertical) * np.array(spatial.width) * length))
    body = []
    for grams in (5, 10, 20, 40):
        speed = math.sqrt(2 * _core.GRAVITY * grams / 1e3 / (FISH.water.density * area))
        body.append([f"{grams}", f"{100 * speed:.0f}", f"{0.5 / speed:.0f}"])
    return rows(["lighter than its water [g]", "rises at [cm/s]", "from 0.5 m in [s]"], body, 0)


def depth_table() -> str:
    """Tabulate the pressure of the water on the hull."""
    body = []
    for depth in (1.0, 2.0, 5.0, 10.0):
        pressure = FISH.water.density * _core.GRAVITY * depth
        area = math.pi / 4 * FISH.spatial.height[0] * FISH.spatial.width[0]  # type: ignore[union-attr]
        body.append([f"{depth:g}", f"{pressure / 1e3:.0f}", f"{pressure * area:.0f}"])
    return rows(["depth [m]", "pressure [kPa]", "force on the head's section [N]"], body, 0)


# Estimates of a 433 MHz module of 20 dBm: sensitivity at 4.8 kbit/s, antennas of both ends, fading over water.
POWER, SENSITIVITY, ANTENNAS, FADING = 20.0, -118.0, -3.0, 20.0  # dBm, dBm, dB, dB
WAVE = 299_792_458 / 433e6  # wavelength [m]


def radio_reach(robot: float, ground: float) -> float:
    """Return the distance [m] of a link between antennas at these heights over the water [m].

    The smaller of free space, 20 log(4 pi d / wave), and a path over flat water, 40 log(d) - 20 log(h1 h2).
    """
    loss = POWER - SENSITIVITY + ANTENNAS - FADING
    return float(min(WAVE / (4 * math.pi) * 10 ** (loss / 20), 10 ** ((loss + 20 * math.log10(robot * ground)) / 40)))


def radio_table() -> str:
    """Tabulate the reach of the radio."""
    body = []
    for height in (0.02, 0.05, 0.10):
        body.append(
            [f"{100 * height:.0f}", *(f"{round(radio_reach(height, ground), -1):.0f}" for ground in (1.5, 3.0, 6.0))]
        )
    heads = [f"ashore at {ground:g} m" for ground in (1.5, 3.0, 6.0)]
    return rows(["antenna of the robot [cm above the water]", *heads], body, 0)


def oil_table() -> str:
    """Tabulate the circuits to be filled."""
    body = []
    for group in FISH.joints:
        line = group.line
        assert line is not None
        filled = f"{line.fill_pressure / 1e3:.0f}"
        body.append(
            [group.name, "2", f"{group.drive_units}", f"{100 * line.length:.0f}", f"{1e3 * line.bore:g}", filled]
        )
    heads = ["joint", "circuits", "drive units in each", "line [cm]", "bore [mm]", "pressure at rest [kPa]"]
    return rows(heads, body)


def limits_table() -> str:
    """Tabulate the parameters that a maker should know before the first swim."""
    names = ("link_timeout", "home_timeout", "manual_timeout", "rise_depth", "voltage_low", "voltage_empty",
             "pressure_work", "pressure_soft", "pressure_hard", "pulse_min", "pulse_max")  # fmt: skip
    texts = {
        "link_timeout": ("s", "silence of the ground that ends a gait"),
        "home_timeout": ("s", "silence of the ground that sends the robot home, or up"),
        "manual_timeout": ("s", "silence of the sticks after which the tail rests"),
        "rise_depth": ("m", "depth below which a robot without a way home ascends"),
        "voltage_low": ("V", "voltage below which the robot goes home, or up"),
        "voltage_empty": ("V", "voltage below which it ascends and disarms"),
        "pressure_work": ("Pa", "pressure above which the beat is reduced"),
        "pressure_soft": ("Pa", "pressure above which a pump goes back"),
        "pressure_hard": ("Pa", "pressure above which the joint is released"),
        "pulse_min": ("s", "shortest pulse of a servo"),
        "pulse_max": ("s", "longest pulse of a servo"),
    }
    at = {p.name: p for p in firmware_table(FISH).parameters}
    body = [
        [f"`{n}`", texts[n][1], *(f"{x:g} {texts[n][0]}" for x in (at[n].standard, at[n].low, at[n].high))]
        for n in names
    ]
    return rows(["parameter", "meaning", "value", "from", "to"], body, 2)


def remedy_table(kind: str) -> str:
    """Tabulate faults or refusals of the firmware with what to do about each."""
    if kind == "faults":
        listed, remedies = (
            {name: (sentence, answer) for name, sentence, answer, *_ in _core.fault_table()},
            FAULT_REMEDIES,
        )
        body = [[f"`{name}`", sentence, answer, remedies[name]] for name, (sentence, answer) in listed.items()]
        heads = ["fault", "the robot says", "it does", "you do"]
    else:
        listed, remedies = dict(_core.refusal_table()[1:]), REFUSAL_REMEDIES  # type: ignore[assignment]
        body = [[f"{sentence}", remedies[name]] for name, sentence in listed.items()]  # type: ignore[misc]
        heads = ["the robot says", "you do"]
    assert set(listed) == set(remedies), set(listed) ^ set(remedies)
    return rows(heads, body, len(heads))


TABLES: dict[str, Callable[[], str]] = {
    "bill of materials": parts_table,
    "wiring": wiring_table,
    "battery divider": divider_table,
    "power of the first gaits": power_table,
    "first swim": first_table,
    "directions": direction_table,
    "trim": trim_table,
    "rise": rise_table,
    "pressure of depth": depth_table,
    "radio reach": radio_table,
    "oil circuits": oil_table,
    "limits of the first swim": limits_table,
    "remedies of faults": lambda: remedy_table("faults"),
    "remedies of refusals": lambda: remedy_table("refusals"),
}
PICTURES: dict[str, Callable[[], Figure]] = {"docs/wiring.svg": lambda: plot_wiring(wiring_of(FISH))}
