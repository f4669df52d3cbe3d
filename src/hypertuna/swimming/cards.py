"""Cards of gaits and swims."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from hypertuna.description.schema.water import LAWS
from hypertuna.display import Card, Facts, Part, Table, cards
from hypertuna.pictures import captioned, curve_svg
from hypertuna.swimming.gait import Gait, Gaits, gait_text
from hypertuna.swimming.outline import slowed, swimming_svg
from hypertuna.swimming.swim import Swim

ACROSS = 24  # most dots drawn along an axis of a grid of gaits


@cards.of(Gait)
def gait_card(gait: Gait) -> Card:
    """Return the card of a gait: its frequency, and the angles of each joint group."""
    angles = np.degrees([gait.amplitude, gait.phase, gait.bias]).round(6) + 0.0
    rows = [(f"{g + 1}", *(f"{angle:.4g}" for angle in row)) for g, row in enumerate(angles.T)]
    columns = ("joint group", "amplitude [deg]", "phase [deg]", "bias [deg]")
    return Card(f"Gait: {gait_text(gait)}", [Table(columns, rows)], lambda: beat_svg(gait))


def beat_svg(gait: Gait, title: str = "One beat as commanded") -> str:
    """Return an SVG of the angle of each joint group over a beat."""
    time = np.linspace(0, 1 / gait.frequency, 61)
    swings = np.sin(2 * np.pi * gait.frequency * time[:, np.newaxis] - gait.phase)
    *others, last = np.degrees(gait.bias + gait.amplitude * swings).T
    curves = [list(zip(time.tolist(), other.tolist(), strict=True)) for other in others]
    text = f"{title}: the last joint group in blue{', the others dashed' * bool(others)}."
    return captioned(curve_svg(time, last, "joint angle [deg] over time [s]", dashed=curves), text)


@cards.of(Swim)
def swim_card(swim: Swim) -> Card:
    """Return the card of a swim: the swimming fish, its results, and whether the beat is settled."""
    model = swim.robot.model
    areas = f", {model.areas} areas" if LAWS[model.water].areas else ""
    content: list[Part] = [(f"{model.water} water, {model.joints} joints{areas}", "dim")]
    if any(swim.current):
        content.append(("current {:g}, {:g} m/s; speed is through the water".format(*swim.current), "dim"))
    content += [Facts(swim.summary())] + ([] if swim.band is None else [swim.band.sentence()])
    content.append((swim.status_text, "green" if swim.settled else "bold red"))
    return Card(f"{swim.robot.name}, {gait_text(swim.gait)}", content, picture_of(swim))


def picture_of(swim: Swim) -> Callable[[], str] | None:
    """Return a function that returns an SVG of a swim; None if the swim diverged."""
    if swim.status == "diverged":
        return None
    return lambda: captioned(swimming_svg(swim), f"One beat from above, {slowed(swim)}.")


@cards.of(Gaits)
def gaits_card(gaits: Gaits) -> Card:
    """Return the card of gaits: their number and their ranges."""
    parts = zip(("frequencies", "amplitudes", "phases", "biases"), gaits.shape, strict=False)
    sizes = " x ".join(f"{count} {name}" for name, count in parts if count > 1)
    facts = {"frequency": f"{_span(gaits.frequency)} Hz"}
    for kind in ("amplitude", "phase", "bias"):
        columns = np.degrees(getattr(gaits, kind)).round(6).T
        if kind != "bias" or columns.any():
            facts[kind] = f"{', '.join(_span(column) for column in columns)} deg"
    title = f"{len(gaits)} gaits{f': {sizes}' if gaits.is_grid else ''}"
    return Card(title, [Facts(facts)], lambda: _gaits_svg(gaits))


def _gaits_svg(gaits: Gaits) -> str:
    """Return an SVG of the last joint group's amplitude over frequency; of one beat if all gaits share both."""
    axes = [gaits.frequency, np.degrees(gaits.amplitude[:, -1])]
    if gaits.is_grid:
        axes = [part.ravel() for part in np.meshgrid(*(axis[:: -(-len(axis) // ACROSS)] for axis in axes))]
    frequency, amplitude = (part[:: -(-len(part) // ACROSS**2)] for part in axes)
    if np.ptp(frequency) == np.ptp(amplitude) == 0:
        return beat_svg(gaits[0], "One beat of the first gait")
    label = "amplitude of the last joint group [deg] over frequency [Hz]"
    text = "Each dot is a gait, or several that differ in another value; of many, some are drawn."
    return captioned(curve_svg(frequency, amplitude, label, dots=True), text)


def _span(values: ArrayLike) -> str:
    """Return the range of values as text: "1 to 6"."""
    low, high = float(np.min(values)), float(np.max(values))
    return f"{low + 0.0:.4g}" if low == high else f"{low + 0.0:.4g} to {high + 0.0:.4g}"
