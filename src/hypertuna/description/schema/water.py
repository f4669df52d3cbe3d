"""The tables of the water in a robot description, one per law, and `LAWS`: how each law reads a robot."""

import math
from bisect import bisect_right
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from hypertuna.description.schema.base import Check, Flag, Fraction, NotNegative, Part, Positive, entry

WaterLaw = Literal["lumped", "strip", "elongated"]
Areas = Literal["consistent", "as-printed"]


class Choice(Part):
    """Model to use unless the caller chooses another."""

    water: WaterLaw = entry(
        "law of the water forces (default: strip)", default="strip", how="choose: strip for new robots"
    )
    joints: Literal["ideal", "bandwidth"] = entry(
        "model of the joints, without or with the lag of their bandwidth",
        default="ideal",
        how="choose: bandwidth if the joints lag",
    )
    areas: Areas = entry(
        "areas of the lumped law: friction on the wetted and drag on the lateral area, or the reverse as printed",
        default="consistent",
        how="choose: consistent, but as-printed to reproduce the paper",
    )


class Lumped(Part, how="fit to steady runs (`identify`)"):
    """Lumped law: force at each center of mass, one value per link."""

    added_mass: tuple[NotNegative, ...] = entry("added mass c_m, as a fraction of the link's mass", usual=(0.0, 5.0))
    friction: tuple[NotNegative, ...] = entry("friction coefficient c_f along the link")
    drag: tuple[NotNegative, ...] = entry("drag coefficient c_d across the link")


def _zeros(law: Mapping[str, Any]) -> tuple[float, ...]:
    """Return a zero for each link, the default value of a column."""
    return (0.0,) * len(law["drag_normal"])


def _ones(law: Mapping[str, Any]) -> tuple[float, ...]:
    """Return a one for each link, the default value of a column."""
    return (1.0,) * len(law["drag_normal"])


# Added mass of a rectangular plate across the flow, over rho pi/4 chord^2 span, by aspect ratio (DNV-RP-C205, 2010).
PLATE_ASPECT = (1.0, 1.25, 1.59, 2.0, 2.5, 3.17, 4.0, 5.0, 6.25, 8.0, 10.0)
PLATE_MASS = (0.579, 0.642, 0.704, 0.757, 0.801, 0.84, 0.872, 0.897, 0.917, 0.934, 0.947)


def plate_mass(aspect: float) -> float:
    """Return the added mass of a plate of an aspect ratio across the flow, over rho pi/4 chord^2 span [1]."""
    if aspect < 1:  # exchange span and chord
        return aspect * plate_mass(1 / aspect) if aspect > 0 else 0.0
    k = min(bisect_right(PLATE_ASPECT, aspect), len(PLATE_ASPECT) - 1)
    (a, b), (low, high) = PLATE_ASPECT[k - 1 : k + 1], PLATE_MASS[k - 1 : k + 1]
    return min(1.0, low + (high - low) * (aspect - a) / (b - a))


def helmbold(aspect: float) -> float:
    """Return the lift slope of a wing of an aspect ratio AR, over that of a slender wing, pi AR/2 (Helmbold) [1]."""
    return 4 / (2 + math.hypot(aspect, 2))


def _aspect(law: Mapping[str, Any]) -> float:
    """Return the default of edge_aspect [1]: the aspect ratio that has the given edge_lift by Helmbold's equation."""
    lift = law.get("edge_lift", 1.0)
    return 4 / lift * math.sqrt(1 - lift) if law.get("edge_height") and lift else 0.0


def _plate(law: Mapping[str, Any]) -> float:
    """Return the default of edge_added_mass [1], over rho pi/4 chord^2 span: that of a plate with edge_aspect."""
    return plate_mass(law.get("edge_aspect", 0.0))


class Strip(Part):
    """Strip law: force per length, integrated along each link, one value per link; h = lateral area / length."""

    drag_normal: tuple[NotNegative, ...] = entry(
        "drag coefficient C_n across the link, on h",
        how="handbook: 1.2 plate or fin, 1.5 ellipse on edge, 1.2 cylinder",
        usual=(0.05, 10.0),
    )
    drag_tangential: tuple[NotNegative, ...] = entry(
        "friction coefficient C_t along the link, on wetted area / length",
        how="tow the straight fish at three speeds (`identify` fits it to steady runs)",
        usual=(5e-4, 1.0),
    )
    added_mass_normal: tuple[NotNegative, ...] = entry(
        "added mass per length across the link, in units of rho pi/4 h^2 (default: 1, potential flow)",
        default_factory=_ones,
        how="1 for elliptical sections, less for a fin, by its aspect ratio (DNV-RP-C205)",
        usual=(0.001, 5.0),
    )
    added_mass_tangential: tuple[NotNegative, ...] = entry(
        "added mass per length along the link, in units of rho pi/4 h^2 (default: 0)",
        default_factory=_zeros,
        how="on the head, Lamb's k1 of an ellipsoid as long and as thick",
        usual=(5e-4, 0.6),
    )
    added_inertia: tuple[NotNegative, ...] = entry(
        "added moment of inertia, in units of strip theory's mu l^3/12, mu the normal added mass (default: 1)",
        default_factory=_ones,
        how="1 by strip theory (`identify` fits it)",
        usual=(0.05, 5.0),
    )
    linear_normal: tuple[NotNegative, ...] = entry(
        "linear drag per length across the link (default: 0)", "Pa s", default_factory=_zeros, how="0 in water"
    )
    linear_tangential: tuple[NotNegative, ...] = entry(
        "linear drag per length along the link (default: 0)",
        "Pa s",
        default_factory=_zeros,
        how="0 in water, along the link, too",
    )
    cross_flow: Flag = entry(
        "form of the normal drag: v_n |v| if true, v_n |v_n| if false",
        default=False,
        how="compare the fits of both forms (`identify`)",
    )
    tail_shedding: Fraction = entry(
        "fraction of Lighthill's reactive force that acts at the trailing edge (default: 1)",
        default=1.0,
        how="1 for a tail fin with a sharp edge (`identify` fits it)",
    )
    drag_beating: tuple[NotNegative, ...] = entry(
        "what the coefficient across the link gains in a flow that beating makes, on h (default: 0)",
        default_factory=_zeros,
        how="2.6 for a fin, 0 for round links (`identify` fits it)",
        usual=(0.0, 20.0),
    )
    blunt_area: tuple[NotNegative, ...] = entry(
        "drag area C_D A of blunt shapes in the flow along the link (default: 0)",
        "m^2",
        default_factory=_zeros,
        how="tow the straight fish at three speeds (`identify` fits it to steady runs)",
    )
    edge_height: NotNegative = entry(
        "height of the trailing edge, the span of the tail fin (default: 0, that of the last link)",
        "m",
        default=0.0,
        how="ruler: span of the tail fin at its trailing edge",
        follows={"height": 1},
    )
    edge_lift: Fraction = entry(
        "lift slope of the tail fin, in units of a slender wing's pi AR/2",
        default=1.0,
        how="4 / (2 + sqrt(4 + A^2)) by Helmbold, A the aspect ratio of the fin",
        usual=(0.06, 2.0),
    )
    edge_aspect: NotNegative = entry(
        "aspect ratio of the tail fin, span over mean chord; 0 for a last link that is a fin of one height "
        "(default: that of edge_lift by Helmbold's equation, with an edge_height)",
        default_factory=_aspect,
        how="ruler: span of the tail fin over its mean chord, which is its area over the span",
    )
    edge_added_mass: NotNegative = entry(
        "added mass of the tail fin across, in units of rho pi/4 chord^2 span (default: a plate's of edge_aspect)",
        default_factory=_plate,
        how="DNV-RP-C205, plates: 0.58, 0.76, 0.87, 0.95 at aspect ratio 1, 2, 4, 10",
    )
    edge_suction: Fraction = entry(
        "fraction of the suction at the fin's leading edge that acts (default: 0, a sharp edge)",
        default=0.0,
        how="0 for a thin fin; a rounded leading edge keeps up to a half in a beat",
    )

    def _checks(self) -> Iterable[Check]:
        if not self.edge_height or not self.edge_aspect or not self.edge_lift:
            return
        added = self.edge_added_mass / (self.edge_aspect * self.edge_lift)
        limit = 4 * added / (1 - self.edge_lift / 2)
        yield Check(
            self.edge_suction <= limit,
            "edge_suction",
            "must be at most 4 edge_added_mass / (edge_aspect edge_lift (1 - edge_lift / 2)): wakes give no energy",
            f"write at most {limit:.3g}, or check the fin's added mass",
        )


class Elongated(Part):
    """Lighthill's elongated-body theory with resistive drag, one value per link; h = lateral area / length."""

    drag_normal: tuple[NotNegative, ...] = entry(
        "drag coefficient C_n across the link, on h", how="as of the strip law", usual=(0.05, 10.0)
    )
    drag_tangential: tuple[NotNegative, ...] = entry(
        "friction coefficient C_t along the link, on wetted area / length",
        how="as of the strip law, from a tow",
        usual=(0.0, 1.0),
    )
    added_mass_normal: tuple[NotNegative, ...] = entry(
        "added mass per length across the link, in units of rho pi/4 h^2 (default: 1, potential flow)",
        default_factory=_ones,
        how="1 for slender bodies",
        usual=(0.0, 5.0),
    )
    added_mass_edge: NotNegative = entry(
        "added mass per length at the trailing edge, in units of rho pi/4 h^2 of the last link: (edge's depth / h)^2",
        default=1.0,
        how="ruler: height of the trailing edge over that of the last link, squared",
    )


class Water(Part):
    """The water and the coefficients of its laws."""

    density: Positive = entry(
        "density of the water (default: 1000, fresh water)",
        "kg/m^3",
        default=1000.0,
        how="1000 fresh, 1025 sea; or a hydrometer",
        usual=(900.0, 1300.0),
    )
    lumped: Lumped | None = entry("coefficients of the lumped law", default=None)
    strip: Strip | None = entry("coefficients of the strip law", default=None)
    elongated: Elongated | None = entry("coefficients of the elongated-body law", default=None)


@dataclass(frozen=True)
class Law:
    """How a law reads a robot, in addition to its own table [water.NAME]."""

    example: str  # a coefficient of the table, as an example in hints
    # Columns of the law that are areas of the links, with the name in [links], by `areas` of [model]; equal names are
    # left out.
    areas: Mapping[Areas, Mapping[str, str]] = field(default_factory=dict)
    dry: tuple[str, ...] = ()  # coefficients whose forces do not scale with density, set to zero in air


LAWS: Mapping[str, Law] = {
    "lumped": Law(
        example="drag",
        areas={
            "consistent": {"friction_area": "wetted_area", "drag_area": "lateral_area"},
            "as-printed": {"friction_area": "lateral_area", "drag_area": "wetted_area"},
        },
        dry=("added_mass",),
    ),
    "strip": Law(example="drag_normal", dry=("linear_normal", "linear_tangential")),
    "elongated": Law(example="drag_normal"),
}
