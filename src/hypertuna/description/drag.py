"""Drag of a swimming body from its shape: friction, form, blunt parts in the flow, and beating of the fin.

Chosen from handbooks and from drag that was measured, not from speeds of robots.
"""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from hypertuna.arrays import Array
from hypertuna.description.shape import DENSITY, FIN_DRAG, Shape

VISCOSITY = 1.0e-6  # m^2/s, kinematic, of water at 20 C
STRIDE = 0.5  # lengths per beat: a tail that beats a fifth of the length, at a Strouhal number of 0.4
# Drag coefficients on the largest section.
# - Heads across the flow: 0.8 flat, 0.2 with rounded edges (Hoerner 1965, chapter 3).
# - Appendages of an underwater vehicle: the sonar has 27.4 % of its drag, nearly as much as the bare hull (Allen et
#   al., cited in doi:10.1007/s00773-018-0558-y): 0.3 in all, of which 0.09 are the hull's.
# - Folded fins: sailfish and swordfish have 0.0075 and 0.0091 of the wetted area, twice a hull (Sagong et al. 2013).
# - Steps and gaps at two joints, 1 % of the length high (Hoerner, chapter 5).
FLAT, ROUNDED, APPENDAGES, FOLDED, GAPS = 0.8, 0.2, 0.2, 0.05, 0.1


class Nose(NamedTuple):
    """A form of body, blunt or streamlined: drag coefficients of its blunt parts over the largest section."""

    words: str  # for its builder
    parts: Mapping[str, float]  # drag coefficients of what is not streamlined, on the largest section
    factor: float  # within which the drag area lies in 90 % of cases
    reason: str


NOSES = {
    "streamlined": Nose(
        "smooth, closed and rounded in front, nothing in the flow but thin fins",
        {"folded fins": FOLDED},
        3.0,
        "fish that coast or are held in a wind tunnel, from a bluegill to a swordfish",
    ),
    "robot": Nose(
        "fish-like, with flat parts, steps, seams, gaps at joints, fins or cables",
        {"rounded edges": ROUNDED, "fins and sensors": APPENDAGES, "steps and gaps at joints": GAPS},
        2.5,
        "a smooth vehicle with fins and sonar has half of it, a model of a glider 7.6 times its theory (Berman 2003)",
    ),
    "blunt": Nose(
        "flat or boxy in front, or open parts that water flows through",
        {"a flat face": FLAT, "fins and sensors": APPENDAGES, "steps and gaps at joints": GAPS},
        2.0,
        "boxfish have ten times the drag of streamlined fish (Blake 1981), as this has; a plate has twice as much",
    ),
}


def friction(shape: Shape, frequency: float) -> float:
    """Return the friction coefficient on the wetted area (ITTC 1957) at the speed of a gait of a frequency [Hz]."""
    reynolds = STRIDE * frequency * shape.length**2 / VISCOSITY
    return 0.075 / (math.log10(max(reynolds, 2000.0)) - 2) ** 2


def blunt_area(shape: Shape, nose: str, frequency: float, wetted: float) -> float:
    """Return the drag area [m^2] beyond skin friction: a streamlined form's of a wetted area [m^2], and the nose's.

    A streamlined body of slenderness d/l has 1 + 1.5 (d/l)^1.5 + 7 (d/l)^3 times its friction (Hoerner, chapter 6).
    """
    slender = shape.slenderness
    form = friction(shape, frequency) * (1.5 * slender**1.5 + 7 * slender**3) * wetted
    result: float = form + sum(NOSES[nose].parts.values()) * math.pi / 4 * shape.width * shape.height
    return result


def beating(shape: Shape, swing: float) -> float:
    """Return the rise of the fin's drag coefficient [1] in a beat whose amplitude at the fin's middle is `swing` [m].

    A plate of chord c has 8 KC^(-1/3) in a flow to and fro of KC = 2 pi a / c (Graham 1980), not that of steady flow.
    """
    keulegan = 2 * math.pi * swing * shape.fin_span / shape.fin_area
    result: float = max(8 * keulegan ** (-1 / 3) - FIN_DRAG, 0.0)
    return result


def beating_of_chord(value: float, ratio: float) -> float:
    """Return the rise `value` of a fin's drag coefficient where the chord is `ratio` times as long, by the same law."""
    result: float = max((value + FIN_DRAG) * ratio ** (1 / 3) - FIN_DRAG, 0.0)
    return result


def swing(shape: Shape, lengths: Sequence[float], amplitude: Sequence[float], phase: Sequence[float]) -> float:
    """Return the amplitude [m] of the fin's middle from amplitude and phase [rad] of the joint before each link.

    The body recoils so that it gains no momentum and no spin: the motion is what a straight line, fitted by mass and
    added mass, leaves of the bending.
    """
    x, height, width = shape.sections(0.0, shape.length)
    section = np.where(x < shape.fin_start * shape.length, math.pi / 4, 1.0) * height * width
    root_mass = np.sqrt(DENSITY * (section + math.pi / 4 * height**2))
    bend = np.zeros(len(x), dtype=complex)
    for joint_x, a, p in zip(np.cumsum(lengths[:-1]), amplitude, phase, strict=True):
        bend += a * np.exp(-1j * p) * np.maximum(x - joint_x, 0.0)
    motion: Array = np.stack([bend.real, bend.imag], axis=1)
    motion = motion - np.stack([np.ones_like(x), x], axis=1) @ np.polyfit(x, motion, 1, w=root_mass)[::-1]
    middle = int(np.searchsorted(x, (1 + shape.fin_start) / 2 * shape.length))
    return float(np.hypot(*motion[middle]))
