"""What `robot new` says of each coefficient of the water that it estimates: its rule, and how far it may be off."""

from collections.abc import Iterator
from typing import NamedTuple

from hypertuna.description.drag import NOSES, STRIDE
from hypertuna.description.shape import FIN_DRAG, Shape, ellipse_drag

GIVEN = "as given to `hypertuna robot new`"


class Estimate(NamedTuple):
    """The rule of an estimate, and the factor within which the true value lies in 90 % of cases, with its reason."""

    rule: str
    factor: float = 1.0  # of a value that is no estimate, or does not matter to a settled beat
    reason: str = ""

    @property
    def source(self) -> str:
        """The entry of ``[sources]``."""
        if self.factor == 1:
            return self.rule
        return f"{self.rule}; within a factor of {self.factor:g} in 90 % of cases: {self.reason}"


def water_estimates(shape: Shape, nose: str, swung: float, given: set[str]) -> dict[str, Estimate]:
    """Return the estimates of ``[water.strip]`` and of the links' areas by key; `given` names the sizes that are known.

    `swung` [m] is the amplitude of the fin's middle in the gait.
    """
    return dict(_estimates(shape, nose, swung, given))


def _estimates(shape: Shape, nose: str, swung: float, given: set[str]) -> Iterator[tuple[str, Estimate]]:
    """Yield keys and estimates."""
    aspect, size = shape.width / shape.height, given & {"height", "width"}
    yield "water.strip", Estimate("estimate: theory and handbooks, for the same shape")
    if not size:
        rule = "estimate: of the same shape"
        yield "links.lateral_area_m2", Estimate(rule, 1.25, "a body that floats may be flatter or rounder")
    yield (
        "water.strip.added_mass_normal",
        Estimate(
            "estimate: potential flow, rho pi/4 h^2 of every section, over the square of the mean h; the fin as a "
            "plate of its aspect ratio (DNV-RP-C205 2010)",
            1.15,
            "sections of other forms have 0.9 to 1.2 times that of an ellipse",
        ),
    )
    rule = "estimate: Lamb's k1 of a prolate spheroid as long and as thick, all on the head"
    yield "water.strip.added_mass_tangential", Estimate(rule)
    rule = f"estimate: {ellipse_drag(aspect):.3g} for an ellipse {aspect:.3g} times as wide as high, {FIN_DRAG:g} for "
    rule += "the fin, a plate (Hoerner 1965, chapter 3), mean over the area"
    yield "water.strip.drag_normal", Estimate(rule, 1.3, "rounded to sharp edges of the same section")
    rule = f"estimate: ITTC 1957 at {STRIDE:g} lengths per beat of the cruise"
    reason = "laminar to rough: coasting bluegills have 0.015 +- 0.007"
    yield "water.strip.drag_tangential", Estimate(rule, 1.6, reason)
    rule = f"estimate: a plate in a flow to and fro has 8 KC^(-1/3), KC = 2 pi a/c (Graham 1980): {swung:.2g} m is the "
    rule += f"amplitude a of the fin's middle in the cruise; less the {FIN_DRAG:g} of steady flow, by the fin's part "
    rule += "of the area"
    reason = "the scatter of plates of finite span, and of the amplitude in free swimming"
    yield "water.strip.drag_beating", Estimate(rule, 1.5, reason)
    kind = NOSES[nose]
    rule = "estimate: Hoerner's form drag of a streamlined body (1965, chapter 6), and on the largest section "
    rule += ", ".join(f"{drag:g} for {part}" for part, drag in kind.parts.items())
    yield "water.strip.blunt_area_m2", Estimate(f"{rule}; fit it to your first steady runs", kind.factor, kind.reason)
    if "fin_span" in given:
        yield "water.strip.edge_height_m", Estimate(GIVEN)
    else:
        rule = "estimate: a fin as high as the body"
        yield "water.strip.edge_height_m", Estimate(rule, 1.3, "a tail fin may be lower or higher than its body")
    if {"fin_span", "fin_chord"} <= given:
        yield "water.strip.edge_aspect", Estimate("span over mean chord, " + GIVEN)
    else:
        rule = "estimate: span^2 over area of the fin"
        yield "water.strip.edge_aspect", Estimate(rule, 1.4, "fins of one span may be larger or smaller by as much")
    rule = "estimate: a plate of the fin's aspect ratio (DNV-RP-C205 2010)"
    yield "water.strip.edge_added_mass", Estimate(rule, 1.1, "other planforms than a rectangle")
    rule = "estimate: Helmbold's lift slope of a wing of the fin's aspect ratio, over pi AR/2"
    yield (
        "water.strip.edge_lift",
        Estimate(rule, 1.15, "the scatter of wings of low aspect ratio, and fins that give way"),
    )
    rule = "estimate: none; a thin fin keeps no suction at the incidences of a beat"
    yield "water.strip.edge_suction", Estimate(rule)
