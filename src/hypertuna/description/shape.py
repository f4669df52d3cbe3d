"""Numbers of a robot from the shape of a slender fish: sections, columns of the links, coefficients of the water.

The body has a NACA four-digit profile in side view and elliptical sections. It ends in a trapezoidal caudal fin as high
as the body. The height follows from the mass, since the fish is neutrally buoyant.
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
FIN_START = 0.85  # distance from the nose to the fin, over the length
FIN_THICKNESS = 0.007  # thickness of the fin over the length
FIN_DRAG = 1.2  # drag coefficient of the fin across steady flow, a plate (Hoerner)
LINKS = ("com_m", "mass_kg", "lateral_area_m2", "wetted_area_m2")  # columns of [links] that the shape gives
STRIP = ("added_mass_normal", "added_inertia", "drag_normal", "drag_tangential", "drag_beating")  # of [water.strip]
STATIONS = 2000  # sections along the body in all integrals


@dataclass(frozen=True)
class Shape:
    """The shape of a fish: sizes of body and caudal fin in m."""

    length: float
    mass: float  # kg
    height: float  # largest height of the body
    width: float  # largest width of the body
    fin_start: float  # distance from the nose to the fin, over the length
    fin_root: float  # height of the fin at its front end
    fin_span: float  # height of the fin at its rear end

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
        """Return the shape of a neutrally buoyant fish; sizes that are not given are estimated.

        `height` and `width` [m] are those of the body without fins; `fin_chord` [m] is the fin's area over its span.
        """
        if mass is None and height is None and width is None:
            mass = float(f"{FULL * length**3:.2g}")
        start = FIN_START if fin_chord is None else 1 - fin_chord / length
        s = start * (np.arange(STATIONS) + 0.5) / STATIONS
        body = math.pi / 4 * float((naca(s) ** 2).mean()) * start * length  # volume over height and width [m]
        fin = 0.0  # volume [m^3]
        for _ in range(20):  # a fixed point: the fin is as high as the body, and takes little of its volume
            hull = None if mass is None else max(mass / DENSITY - fin, 0.01 * mass / DENSITY)
            body_height, body_width = _section(height, width, None if hull is None else hull / body)
            span = fin_span or body_height
            root = span if fin_chord else float(naca(start)) * body_height
            fin = FIN_THICKNESS * length * (1 - start) * length * (root + span) / 2
        mass = mass or float(f"{DENSITY * (body * body_height * body_width + fin):.3g}")
        return cls(length, mass, body_height, body_width, start, root, span)

    @property
    def buoyancy(self) -> float:
        """Mass of the water that the body displaces, over the mass of the fish: 1 if neutrally buoyant."""
        _, height, width = self.sections(0.0, self.fin_start * self.length)
        body = math.pi / 4 * float((height * width).mean()) * self.fin_start * self.length
        return DENSITY * body / self.mass

    def sections(self, start: float, end: float) -> tuple[Array, Array, Array]:
        """Return stations (n,) from `start` to `end`, relative to start, and the heights and widths there (n,) [m]."""
        count = max(16, round(STATIONS * (end - start) / self.length))
        x = (np.arange(count) + 0.5) / count * (end - start)
        s = (start + x) / self.length
        body, outline = s < self.fin_start, naca(np.minimum(s, self.fin_start))
        fin = self.fin_root + (self.fin_span - self.fin_root) * (s - self.fin_start) / (1 - self.fin_start)
        thickness = FIN_THICKNESS * self.length
        return x, np.where(body, self.height * outline, fin), np.where(body, self.width * outline, thickness)

    @property
    def fin_area(self) -> float:
        """Area of one side of the caudal fin [m^2]."""
        return (self.fin_root + self.fin_span) / 2 * (1 - self.fin_start) * self.length

    @property
    def fin_aspect(self) -> float:
        """Aspect ratio of the caudal fin, span^2 / area."""
        return self.fin_span**2 / self.fin_area

    @property
    def fin_reduction(self) -> float:
        """Added mass of the fin as a plate, over the sum of its sections' added masses [1]."""
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
        """Added mass along the body over the displaced mass [1]: Lamb's k1 of a prolate spheroid."""
        e = math.sqrt(1 - min(self.slenderness, 0.999) ** 2)
        alpha = 2 * (1 - e**2) / e**3 * (math.atanh(e) - e)
        return alpha / (2 - alpha)


def naca(s: ArrayLike) -> Array:
    """Return the height of a NACA four-digit profile over its largest height, at fractions s of its length [1]."""
    s = np.asarray(s)
    result: Array = 2.969 * np.sqrt(s) - 1.26 * s - 3.516 * s**2 + 2.843 * s**3 - 1.015 * s**4
    return result


def ellipse_drag(aspect: float) -> float:
    """Return the drag coefficient of an ellipse across the flow; aspect: its width over its height (Hoerner)."""
    return 1.98 - 0.78 * aspect


def _section(height: float | None, width: float | None, area: float | None) -> tuple[float, float]:
    """Return height and width of a section [m]; a missing one follows from their product [m^2] or a usual ratio."""
    if height is not None and width is not None:
        return height, width
    if area is None:
        return (height, ASPECT * height) if height is not None else ((width or 0.0) / ASPECT, width or 0.0)
    if height is None and width is None:
        return math.sqrt(area / ASPECT), math.sqrt(area * ASPECT)
    return (height, area / height) if height is not None else (area / (width or 1.0), width or 0.0)


def link_lengths(count: int, length: float) -> tuple[float, ...]:
    """Return the lengths of links [m]: the head is half of the fish, or seven tenths with a single joint."""
    head_length = round(length * (0.7 if count == 2 else 0.5), 4)
    link = round((length - head_length) / (count - 1), 4)
    return (head_length, *[link] * (count - 2), round(length - head_length - link * (count - 2), 10))


def link_columns(
    shape: Shape, lengths: Sequence[float], friction: float, beating: float
) -> tuple[dict[str, list[float]], dict[str, list[float]]]:
    """Return the columns of ``[links]`` and ``[water.strip]`` that follow from the sections of each link.

    `friction` is the coefficient on the wetted area, `beating` the rise of the fin's drag coefficient in a beat.
    """
    starts = np.cumsum([0.0, *lengths])
    rows = [_link(shape, start, length) for start, length in zip(starts, lengths, strict=False)]
    for row in rows:
        row |= {"drag_tangential": friction, "drag_beating": beating * row.pop("fin_share")}
    links, strip = ({key: [float(f"{row[key]:.4g}") for row in rows] for key in keys} for keys in (LINKS, STRIP))
    ahead = shape.added_mass_ahead * shape.mass / (DENSITY * math.pi / 4 * rows[0]["lateral_area_m2"] ** 2 / lengths[0])
    strip["added_mass_tangential"] = [float(f"{ahead:.3g}")] + [0.0] * (len(lengths) - 1)
    links["mass_kg"] = [float(f"{m * shape.mass / sum(links['mass_kg']):.4g}") for m in links["mass_kg"]]
    links["mass_kg"][0] = float(f"{links['mass_kg'][0] + shape.mass - sum(links['mass_kg']):.10g}")  # exact sum
    return links, strip


def edge(shape: Shape) -> dict[str, float]:
    """Return the keys of ``[water.strip]`` for the trailing edge; the lift follows from Helmbold's equation."""
    aspect = shape.fin_aspect
    edge = {"height_m": shape.fin_span, "aspect": aspect, "added_mass": plate_mass(aspect), "lift": helmbold(aspect)}
    return {f"edge_{key}": float(f"{value:.3g}") for key, value in edge.items()} | {"edge_suction": 0.0}


def _link(shape: Shape, start: float, length: float) -> dict[str, float]:
    """Return by key the numbers of a link that begins at a station [m], integrated over its sections."""
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
