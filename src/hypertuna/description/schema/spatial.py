"""The tables of a robot description that motion in space needs: heights and sections of the links, fins."""

from collections.abc import Iterator

from hypertuna.description.schema.base import (
    Fraction,
    NotNegative,
    Part,
    Positive,
    PositiveDegrees,
    Real,
    Rule,
    entry,
    inside,
)


class Spatial(Part, table="spatial"):
    """The links in space, one value per link; heights are above the axis through the joints."""

    com_height: tuple[Real, ...] = entry("height of each center of mass", "m")
    volume: tuple[Positive, ...] = entry("volume of each link, for its buoyancy", "m^3")
    buoyancy_center: tuple[NotNegative, ...] = entry(
        "distance of each center of buoyancy from the link's front end", "m"
    )
    buoyancy_height: tuple[Real, ...] = entry(
        "height of each center of buoyancy, where the planar water forces act too", "m"
    )
    height: tuple[Positive, ...] = entry("height of each section, mean over the link", "m")
    width: tuple[Positive, ...] = entry("width of each section, mean over the link", "m")
    drag_vertical: tuple[NotNegative, ...] = entry("drag coefficient up and down, on length x width")
    added_mass_vertical: tuple[NotNegative, ...] = entry(
        "added mass per length up and down, in units of rho pi/4 width^2"
    )
    drag_roll: tuple[NotNegative, ...] = entry(
        "drag coefficient of a section's height in rotation about the link's axis"
    )
    shedding_vertical: Fraction = entry(
        "fraction of Lighthill's vertical reactive force, of the widest section, that acts at the tail end", default=0.0
    )
    inertia_roll: tuple[Positive, ...] | None = entry(
        "moment of inertia about the axis of each link through its center of mass (default: an ellipsoid's)",
        "kg m^2",
        default=None,
    )
    inertia_pitch: tuple[Positive, ...] | None = entry(
        "moment of inertia about the axis across each link through its center of mass (default: an ellipsoid's)",
        "kg m^2",
        default=None,
    )

    def centers(self, length: tuple[float, ...]) -> Iterator[Rule]:
        """Yield the rules that every center of buoyancy lies inside its link."""
        fix = "measure it from the link's front end in m"
        return inside(self.buoyancy_center, length, "spatial.buoyancy_center_m", fix)


class Fins(Part, table="fins"):
    """The pair of pectoral fins: flat plates on both sides of the head, pitched by servos."""

    x: NotNegative = entry("distance of the centers of area from the nose, along the head", "m")
    y: Positive = entry("distance of the centers of area from the middle plane", "m")
    z: Real = entry("height of the centers of area above the axis through the joints", "m")
    span: Positive = entry("span of one fin", "m")
    chord: Positive = entry("chord of one fin", "m")
    stall: PositiveDegrees = entry("angle of attack at which half of the flow is stalled", "deg")
    drag_zero: NotNegative = entry("drag coefficient along the plate")
    bandwidth: Positive = entry("bandwidth of the servos' first-order lag", "Hz")
    speed: Positive = entry("largest rate of the servos", "rad/s")

    def _rules(self) -> Iterator[Rule]:
        fix = "measure it from the middle plane to the middle of a fin, in m"
        yield Rule(self.y >= self.span / 2, "y", f"must be at least half of span_m = {self.span:g}", fix)

    def on_head(self, head: float) -> Rule:
        """Return the rule that the fins are on the head."""
        text, fix = f"must be on the head, at most {head:g}", "measure it from the nose in m"
        return Rule(self.x <= head, "fins.x_m", text, fix, f"{self.x:g}")
