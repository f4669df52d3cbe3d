"""Added mass and inertia, lift slope, side suction of rectangular plates: python validation/flow/fin.py

Lattices of vortex rings in three dimensions. A ring around each panel is a sheet of constant doublets. Added mass and
inertia: the plate starts across itself, or turns about mid-chord, no wake yet, the jump of potential is the ring's
strength, and m = rho sum(strength area). Lift slope: a plane wake leaves the trailing edge; rings a quarter of a panel
behind their panels, flow tangential at three quarters (Falkner's and Weissinger's rule). Suction of the side edges:
near an edge the jump of potential is 4 C sqrt(r), and the edge is pulled by pi rho C^2 per length. Errors fall as one
over the number of panels, and are extrapolated from two lattices.
"""

import math
from typing import NamedTuple

import numpy as np

FAR = 1e4  # chords behind the plate, where the wake ends
ACROSS = (8, 16)  # panels along the chord, of two lattices from which results are extrapolated
# DNV-RP-C205 (2010), table D-2: added mass of a rectangular plate over rho pi/4 c^2 b, by b/c
MEASURED = {1.0: 0.579, 2.0: 0.757, 4.0: 0.872, 5.0: 0.897, 10.0: 0.947}


class Plate(NamedTuple):
    """Coefficients of a rectangular plate."""

    aspect: float  # span over chord
    added_mass: float  # over rho pi/4 c^2 b, that of a strip
    lift_slope: float  # 1/rad, on the area
    added_inertia: float  # about mid-chord, over M/12, that of a strip with the plate's added mass M
    side_suction: (
        float  # of both side edges, on the area, over sin^2 of the incidence: Polhamus' K_v without leading edge
    )


def segment(points: np.ndarray, start: np.ndarray, end: np.ndarray, core: float = 0.0) -> np.ndarray:
    """Return the velocity (n, m, 3) of unit vortex segments (m, 3) at points (n, 3), by Biot and Savart.

    Within the radius of the core the velocity fades to zero.
    """
    a, b = points[:, None] - start, points[:, None] - end
    cross, along = np.cross(a, b), end - start
    square = np.einsum("...i,...i", cross, cross) + core**2 * np.einsum("mi,mi->m", along, along)
    lengths = [np.maximum(np.linalg.norm(each, axis=2), 1e-12)[..., None] for each in (a, b)]
    part = np.einsum("mi,nmi->nm", along, a / lengths[0] - b / lengths[1])
    return cross * np.where(square > 1e-18, part / (4 * math.pi * np.maximum(square, 1e-18)), 0.0)[..., None]


def normal_velocity(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Return the velocity (n, m) across the plate of unit rings (m, 4, 3) at points (n, 3)."""
    sides = (segment(points, corners[:, k], corners[:, (k + 1) % 4]) for k in range(4))
    return np.sum([side[..., 2] for side in sides], axis=0)


def rings(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return the corners (m, 4, 3) of the rings between lines at x and y, panels along y fastest."""
    places = [(x[:-1], y[:-1]), (x[1:], y[:-1]), (x[1:], y[1:]), (x[:-1], y[1:])]
    corner = [np.stack([*np.meshgrid(*place, indexing="ij")], axis=-1).reshape(-1, 2) for place in places]
    return np.pad(np.stack(corner, axis=1), ((0, 0), (0, 0), (0, 1)))


def lattice(aspect: float, across: int) -> tuple[float, float, float]:
    """Return added mass, lift slope and added inertia of a plate of chord 1, with `across` panels along it."""
    count = max(across, round(aspect * across))
    x, y = np.linspace(0, 1, across + 1), np.linspace(-aspect / 2, aspect / 2, count + 1)
    panel, area = rings(x, y), aspect / (across * count)
    middle = panel.mean(axis=1)
    speeds = np.stack([np.ones(across * count), middle[:, 0] - 0.5])  # across itself, and about mid-chord
    mass, inertia = np.abs(np.sum(speeds * np.linalg.solve(normal_velocity(middle, panel), speeds.T).T, axis=1)) * area
    last = circulation(x, y)[-1]
    return mass / (math.pi / 4 * aspect), 2 * abs(last.sum()) / count, 12 * inertia / mass


def circulation(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return the strengths (along x, along y) of the rings of a plate with its wake, per incidence and speed."""
    rows, count, shift = len(x) - 1, len(y) - 1, (x[1] - x[0]) / 4
    wake = rings(np.array([x[-1] + shift, FAR]), y)
    points = rings(x, y).mean(axis=1) + np.array([shift, 0, 0])
    matrix = normal_velocity(points, rings(x + shift, y))
    matrix[:, -count:] += normal_velocity(points, wake)
    return np.linalg.solve(matrix, np.ones(rows * count)).reshape(rows, count)


def side_suction(aspect: float, across: int) -> float:
    """Return the suction of both side edges of a plate of chord 1.

    With a = aspect / 2, jump^2 / (a^2 - y^2) is extrapolated to the edge: 16 C^2 / (2 a). Lattices act
    as if wider than their rings by a quarter of a panel at each end.
    """
    count = max(12, round(min(aspect, 2) * across))
    half = aspect / 2 * count / (count + 0.5)
    y = np.linspace(-half, half, count + 1)
    jump, middle = circulation(np.linspace(0, 1, across + 1), y), (y[1:] + y[:-1]) / 2
    scaled, outer = jump**2 / (aspect**2 / 4 - middle**2), slice(count // 2, None)
    edge = [np.polyval(np.polyfit(middle[outer], row[outer], 2), aspect / 2) for row in scaled]
    return math.pi / 4 * float(np.mean(edge))


def plate(aspect: float) -> Plate:
    """Compute a plate, extrapolated to panels without size."""
    coarse, fine = (np.array([*lattice(aspect, across), side_suction(aspect, across)]) for across in ACROSS)
    return Plate(aspect, *(2 * fine - coarse).tolist())


def main() -> None:
    """Print added mass and lift slope over the aspect ratio, beside formulas."""
    head = "b/c | added mass | tables | AR/sqrt(1 + AR^2) | lift slope | Helmbold | over pi AR/2 | K_v | pi/(1 + AR/2)"
    print(f"| {head} | added inertia |")
    print("|" + "---:|" * 10)
    for aspect in (0.5, *MEASURED):
        found = plate(aspect)
        helmbold = 2 * math.pi * aspect / (2 + math.sqrt(aspect**2 + 4))
        table = f"{MEASURED[aspect]:.3f}" if aspect in MEASURED else ""
        formula, slender = aspect / math.sqrt(1 + aspect**2), math.pi / 2 * aspect
        cells = f"{found.added_mass:.3f} | {table} | {formula:.3f} | {found.lift_slope:.2f} | {helmbold:.2f}"
        suction = f"{found.side_suction:.2f} | {math.pi / (1 + aspect / 2):.2f} | {found.added_inertia:.3f}"
        print(f"| {aspect:g} | {cells} | {found.lift_slope / slender:.3f} | {suction} |")


if __name__ == "__main__":
    main()
