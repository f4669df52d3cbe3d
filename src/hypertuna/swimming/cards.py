"""What notebooks and shells show of gaits, swims, turns and gradients."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from hypertuna.description.robot import Robot
from hypertuna.display import Card, number
from hypertuna.pictures import BARS, bars_svg, captioned, curve_svg
from hypertuna.swimming.beat import STATUSES
from hypertuna.swimming.gait import Gait, Gaits
from hypertuna.swimming.outline import circling_svg, slowed, swimming_svg
from hypertuna.swimming.sweep import Gradient
from hypertuna.swimming.swim import STRAIGHT, Swim, swim
from hypertuna.swimming.turn import Turning

INFLUENCES = ("speed", "cost_of_transport")  # that a card of a gradient shows
ACROSS = 24  # dots along an axis of a grid of gaits, at most


def gait_text(gait: Gait) -> str:
    """Write a gait: ``6 Hz, amplitude 16, 25 deg, phase 0, 40 deg``."""
    parts = [f"{gait.frequency:.4g} Hz"]
    for kind in ("amplitude", "phase", "bias"):
        angles = np.degrees(getattr(gait, kind)).round(6)
        if kind != "bias" or angles.any():
            parts.append(f"{kind} {', '.join(f'{angle + 0.0:.3g}' for angle in angles)} deg")
    return ", ".join(parts)


def gait_card(gait: Gait) -> Card:
    """Show the frequency and the angles of each joint group."""
    angles = np.degrees([gait.amplitude, gait.phase, gait.bias]).round(6) + 0.0
    rows = [(f"{g + 1}", *(f"{angle:.4g}" for angle in row)) for g, row in enumerate(angles.T)]
    return Card(
        f"Gait: {gait_text(gait)}",
        (),
        "",
        ("joint group", "amplitude [deg]", "phase [deg]", "bias [deg]"),
        rows,
        lambda: beat_svg(gait),
    )


def beat_svg(gait: Gait, what: str = "One beat as commanded") -> str:
    """Draw the angle of each joint group over a beat."""
    time = np.linspace(0, 1 / gait.frequency, 61)
    swings = np.sin(2 * np.pi * gait.frequency * time[:, np.newaxis] - gait.phase)
    *others, last = np.degrees(gait.bias + gait.amplitude * swings).T
    curves = [list(zip(time.tolist(), other.tolist(), strict=True)) for other in others]
    text = f"{what}: the last joint group in blue{', the others dashed' * bool(others)}."
    return captioned(curve_svg(time, last, "joint angle [deg] over time [s]", dashed=curves), text)


def swim_facts(swim: Swim) -> list[tuple[str, str]]:
    """Return the six numbers of a swim, and between which speeds it lies by the estimates of the robot's file."""
    facts = [
        ("speed", f"{number(swim.speed, 'm/s')} ({number(swim.speed_bl, 'BL/s', 2)})"),
        ("mechanical power", number(swim.mechanical_power, "W")),
        ("cost of transport", number(swim.cost_of_transport, "J/(kg m)")),
        ("Strouhal number", number(swim.strouhal)),
        ("tail excursion", number(1e3 * swim.tail_excursion, "mm")),
        ("stride length", number(swim.stride_length, "BL")),
    ]
    if swim.turn_radius < STRAIGHT * swim.robot.body.length:
        facts[-1] = ("turn radius", number(swim.turn_radius, "m"))
    if swim.band is not None:
        facts.insert(1, ("speed by the estimates", f"{swim.band.ends()} m/s"))
    return facts


def swim_card(swim: Swim) -> Card:
    """Show the swimming fish and six numbers."""
    title = f"{swim.robot.name} swims at {gait_text(swim.gait)}"
    start = "" if swim.from_rest is None else f", {swim.from_rest:g} s from rest"
    return Card(title + start, swim_facts(swim), swim.status_text, picture=picture_of(swim))


def picture_of(swim: Swim) -> Callable[[], str] | None:
    """Return what draws a swim; None if it diverged."""
    if swim.status == "diverged":
        return None
    return lambda: captioned(swimming_svg(swim), f"One beat from above, {slowed(swim)}.")


def gaits_card(gaits: Gaits) -> Card:
    """Show the size and the ranges of gaits."""
    parts = zip(("frequencies", "amplitudes", "phases", "biases"), gaits.shape, strict=False)
    sizes = " x ".join(f"{count} {name}" for name, count in parts if count > 1)
    facts = [("frequency", f"{_span(gaits.frequency)} Hz")]
    for kind in ("amplitude", "phase", "bias"):
        columns = np.degrees(getattr(gaits, kind)).round(6).T
        if kind != "bias" or columns.any():
            facts.append((kind, f"{', '.join(_span(column) for column in columns)} deg"))
    title = f"{len(gaits)} gaits{f': {sizes}' if gaits.is_grid else ''}"
    return Card(title, facts, picture=lambda: _gaits_svg(gaits))


def _gaits_svg(gaits: Gaits) -> str:
    """Draw the amplitudes of the last joint group over the frequencies; of a single pair the first gait."""
    axes = [gaits.frequency, np.degrees(gaits.amplitude[:, -1])]
    if gaits.is_grid:
        axes = [part.ravel() for part in np.meshgrid(*(axis[:: -(-len(axis) // ACROSS)] for axis in axes))]
    frequency, amplitude = (part[:: -(-len(part) // ACROSS**2)] for part in axes)
    if np.ptp(frequency) == np.ptp(amplitude) == 0:
        return beat_svg(gaits[0], "One beat of the first gait")
    label = "amplitude of the last joint group [deg] over frequency [Hz]"
    text = "Each dot is a gait, or several that differ in another value; of many, some are drawn."
    return captioned(curve_svg(frequency, amplitude, label, dots=True), text)


def gradient_card(gradient: Gradient) -> Card:
    """Show how much each parameter changes speed and cost of transport, the largest influence first."""
    influence = {name: gradient.influence(name) for name in INFLUENCES}
    order = np.argsort(-np.abs(influence["speed"]))
    rows = [
        (gradient.names[k], *(f"{influence[name][k]:+z.2f} %" for name in INFLUENCES))
        for k in order
        if any(influence[name][k] for name in INFLUENCES)
    ]
    columns = ("parameter", *(name.replace("_", " ") for name in INFLUENCES))
    title = f"Influence on {gait_text(gradient.gait)} of {gradient.robot.name}"
    text = "Change of the result for 1 % more of the parameter, of an angle for 1 deg more."
    return Card(title, (), text, columns, rows, lambda: _influence_svg(gradient, order[:BARS].tolist()))


def _influence_svg(gradient: Gradient, first: list[int]) -> str:
    """Draw the largest influences on the speed."""
    speed = gradient.influence("speed").tolist()
    rows = [(gradient.names[k], 0.0, speed[k]) for k in first]
    return captioned(
        bars_svg(rows, "change of the speed [%]"),
        f"The {len(first)} parameters with the largest influence on the speed.",
    )


def turning_card(turning: Turning) -> Card:
    """Show the tightest turns of a grid."""
    settled = int((turning.sweep.status == STATUSES.index("settled")).sum())
    facts = [("gaits", f"{len(turning.gaits)}"), ("settled", f"{settled}")]
    text, picture = "None of the settled gaits turns.", None
    if turning.tightest is not None:
        picture = partial(_turn_svg, turning.robot, turning.tightest.gait)
        text = f"Tightest turn: {gait_text(turning.tightest.gait)}."
        facts += [
            ("tightest turn", number(turning.tightest.turn_radius, "m")),
            ("in body lengths", number(turning.tightest.turn_radius / turning.robot.body.length, "BL")),
            ("its speed", number(turning.tightest.speed, "m/s")),
        ]
    if turning.forward is not None:
        facts.append(("tightest head first", number(turning.forward.turn_radius, "m")))
    return Card(f"Turns of {turning.robot.name}", facts, text, picture=picture)


def _turn_svg(robot: Robot, gait: Gait) -> str:
    """Draw the body on its circle."""
    return captioned(circling_svg(swim(robot, gait)), "The tightest turn from above, in real time.")


def _span(values: ArrayLike) -> str:
    """Write the range of values."""
    low, high = float(np.min(values)), float(np.max(values))
    return f"{low + 0.0:.4g}" if low == high else f"{low + 0.0:.4g} to {high + 0.0:.4g}"
