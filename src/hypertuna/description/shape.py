"""Numbers of a robot from the shape of a slender fish: sections, links, water; each has its rule in a sentence.

The body is a NACA four-digit profile in side view, of elliptical sections, and ends in a trapezoidal caudal fin as high
as the body. Its height follows from the mass, for it floats neutrally.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from hypertuna.arrays import Array
from hypertuna.description.schema.water import helmbold, plate_mass

DENSITY = 1000.0  # kg/m^3, fresh water
ASPECT = 0.6  # width over height of a section
FULL = 20.0  # kg/m^3: mass of a slender fish over its length cubed
FIN_START = 0.85  # of the length
FIN_THICKNESS = 0.007  # of the length
FIN_DRAG = 1.2  # coefficient of the fin across steady flow, a plate (Hoerner)
LINKS = ("com_m", "mass_kg", "lateral_area_m2", "wetted_area_m2")
STRIP = ("added_mass_normal", "added_inertia", "drag_normal", "drag_tangential", "drag_beating")
STATIONS = 2000  # along the body, of all integrals


@dataclass(frozen=True)
class Shape:
    """A fish: its sections from nose to tail tip, sizes in m."""

    length: float
    mass: float  # kg
    height: float  # largest of the body
    width: float  # largest of the body
    fin_start: float  # of the length
    fin_root: float  # height of the fin at its front end
    fin_span: float  # at its rear end

    @classmethod
    def of(
        cls,
        length: float,
        mass: float | None = None,
        *,
        height: float | None = None,
        width: float | None = None,
        fin_span: float | None = None,
        fin_chord: float | None = None,
    ) -> Self:
        """Return the shape of a fish that floats, with a height, width, mass and tail fin estimated where not given.

        `height` and `width` [m] are those of the body without fins; `fin_chord` [m] is the fin's area over its span.
        """
        if mass is None and height is None and width is None:
            mass = float(f"{FULL * length**3:.2g}")
        start = FIN_START if fin_chord is None else 1 - fin_chord / length
        s = start * (np.arange(STATIONS) + 0.5) / STATIONS
        body = math.pi / 4 * float((naca(s) ** 2).mean()) * start * length  # volume over height and width [m]
        fin = 0.0  # volume [m^3]
        for _ in range(20):  # a fin as high as the body is a small part of its volume
            hull = None if mass is None else max(mass / DENSITY - fin, 0.01 * mass / DENSITY)
            high, wide = _section(height, width, None if hull is None else hull / body)
            span = fin_span or high
            root = span if fin_chord else float(naca(start)) * high
            fin = FIN_THICKNESS * length * (1 - start) * length * (root + span) / 2
        mass = mass or float(f"{DENSITY * (body * high * wide + fin):.3g}")
        return cls(length, mass, high, wide, start, root, span)

    @property
    def buoyancy(self) -> float:
        """Volume of the sections over the volume of water as heavy as the fish: 1 where it floats."""
        _, height, width = self.sections(0.0, self.fin_start * self.length)
        body = math.pi / 4 * float((height * width).mean()) * self.fin_start * self.length
        return DENSITY * body / self.mass

    def sections(self, start: float, end: float) -> tuple[Array, Array, Array]:
        """Return stations behind `start` (n,) and the height and width of the section at each (n,), all in m."""
        count = max(16, round(STATIONS * (end - start) / self.length))
        x = (np.arange(count) + 0.5) / count * (end - start)
        s = (start + x) / self.length
        body, outline = s < self.fin_start, naca(np.minimum(s, self.fin_start))
        fin = self.fin_root + (self.fin_span - self.fin_root) * (s - self.fin_start) / (1 - self.fin_start)
        thickness = FIN_THICKNESS * self.length
        return x, np.where(body, self.height * outline, fin), np.where(body, self.width * outline, thickness)

    @property
    def fin_area(self) -> float:
        """Area of the caudal fin [m^2], one side."""
        return (self.fin_root + self.fin_span) / 2 * (1 - self.fin_start) * self.length

    @property
    def fin_aspect(self) -> float:
        """Aspect ratio of the caudal fin, span^2 / area."""
        return self.fin_span**2 / self.fin_area

    @property
    def fin_reduction(self) -> float:
        """Added mass of the fin as a plate over the sum of its sections' added masses [1]."""
        _, height, _ = self.sections(self.fin_start * self.length, self.length)
        chord = self.fin_span / self.fin_aspect
        plate = plate_mass(self.fin_aspect) * chord**2 * self.fin_span
        return min(1.0, plate / (float((height**2).mean()) * (1 - self.fin_start) * self.length))

    @property
    def slenderness(self) -> float:
        """Diameter of a circle with the area of the largest section, over the length [1]."""
        return math.sqrt(self.height * self.width) / self.length

    @property
    def added_mass_ahead(self) -> float:
        """Added mass along the body over its mass: Lamb's k1 of a prolate spheroid."""
        e = math.sqrt(1 - min(self.slenderness, 0.999) ** 2)
        alpha = 2 * (1 - e**2) / e**3 * (math.atanh(e) - e)
        return alpha / (2 - alpha)


def naca(s: ArrayLike) -> Array:
    """Return the height of a NACA four-digit profile at fractions of its length, relative to its largest."""
    s = np.asarray(s)
    result: Array = 2.969 * np.sqrt(s) - 1.26 * s - 3.516 * s**2 + 2.843 * s**3 - 1.015 * s**4
    return result


def ellipse_drag(aspect: float) -> float:
    """Return the drag coefficient of an ellipse across the flow, by its width over its height (Hoerner)."""
    return 1.98 - 0.78 * aspect


def _section(height: float | None, width: float | None, area: float | None) -> tuple[float, float]:
    """Return height and width [m], those not given from their product [m^2] or a usual ratio."""
    if height is not None and width is not None:
        return height, width
    if area is None:
        return (height, ASPECT * height) if height is not None else ((width or 0.0) / ASPECT, width or 0.0)
    if height is None and width is None:
        return math.sqrt(area / ASPECT), math.sqrt(area * ASPECT)
    return (height, area / height) if height is not None else (area / (width or 1.0), width or 0.0)


def link_lengths(count: int, length: float) -> tuple[float, ...]:
    """Return the lengths of links [m]: the head is half of the fish, or seven tenths before a single joint."""
    head_length = round(length * (0.7 if count == 2 else 0.5), 4)
    link = round((length - head_length) / (count - 1), 4)
    return (head_length, *[link] * (count - 2), round(length - head_length - link * (count - 2), 10))


def link_columns(
    shape: Shape, lengths: Sequence[float], friction: float, beating: float
) -> tuple[dict[str, list[float]], dict[str, list[float]]]:
    """Return the columns of ``[links]`` and ``[water.strip]`` that follow from the sections of each link.

    `friction` is the coefficient on the wetted area, `beating` what the fin's drag coefficient gains in a beat.
    """
    starts = np.cumsum([0.0, *lengths])
    rows = [_link(shape, start, length) for start, length in zip(starts, lengths, strict=False)]
    for row in rows:
        row |= {"drag_tangential": friction, "drag_beating": beating * row.pop("fin_share")}
    links, strip = ({key: [float(f"{row[key]:.4g}") for row in rows] for key in keys} for keys in (LINKS, STRIP))
    ahead = shape.added_mass_ahead * shape.mass / (DENSITY * math.pi / 4 * rows[0]["lateral_area_m2"] ** 2 / lengths[0])
    strip["added_mass_tangential"] = [float(f"{ahead:.3g}")] + [0.0] * (len(lengths) - 1)
    links["mass_kg"] = [float(f"{m * shape.mass / sum(links['mass_kg']):.4g}") for m in links["mass_kg"]]
    links["mass_kg"][0] = float(f"{links['mass_kg'][0] + shape.mass - sum(links['mass_kg']):.10g}")  # exact in all
    return links, strip


def edge(shape: Shape) -> dict[str, float]:
    """Return the keys of ``[water.strip]`` for the trailing edge; its lift is by Helmbold's equation."""
    aspect = shape.fin_aspect
    edge = {"height_m": shape.fin_span, "aspect": aspect, "added_mass": plate_mass(aspect), "lift": helmbold(aspect)}
    return {f"edge_{key}": float(f"{value:.3g}") for key, value in edge.items()} | {"edge_suction": 0.0}


def _link(shape: Shape, start: float, length: float) -> dict[str, float]:
    """Return the numbers of a link that begins at a station [m], integrated over its sections, by key."""
    x, height, width = shape.sections(start, start + length)
    fin = start + x >= shape.fin_start * shape.length
    section = np.where(fin, height * width, math.pi / 4 * height * width)
    perimeters = np.where(fin, 2 * height, perimeter(height, width))
    return {
        "com_m": float((section * x).sum() / section.sum()),
        "mass_kg": DENSITY * float(section.mean()) * length,
        "lateral_area_m2": float(height.mean()) * length,
        "wetted_area_m2": float(perimeters.mean()) * length,
        "added_mass_normal": float((np.where(fin, shape.fin_reduction, 1) * height**2).mean() / height.mean() ** 2),
        "drag_normal": float(
            (np.where(fin, FIN_DRAG, ellipse_drag(shape.width / shape.height)) * height).mean() / height.mean()
        ),
        "added_inertia": 1.0,
        "fin_share": float(np.where(fin, height, 0.0).mean() / height.mean()),
    }


def perimeter(height: Array, width: Array) -> Array:
    """Return the perimeter of an ellipse [m] (Ramanujan)."""
    a, b = height / 2, width / 2
    result: Array = math.pi * (3 * (a + b) - np.sqrt((3 * a + b) * (a + 3 * b)))
    return result
