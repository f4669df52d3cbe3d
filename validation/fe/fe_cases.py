"""Validation of the finite elements: cases whose answer theory knows, computed and in theory side by side.

Each case takes the energies, the order of elements and Newton's method of the joint's model.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from fe_blocks import STRAINS, cantilever, closed_form, cube_stress
from fe_hose import resolved_hose
from fe_tube import CARRIER, ideal_pull, ideal_stretch, load, pull, tube

from hypertuna import _core
from hypertuna.actuation.silicone import Mooney
from hypertuna.actuation.soft_joint import LUMEN_MIN, drive_unit, mooney
from hypertuna.description.robot import Robot
from hypertuna.fe.energies import LAWS, Solid, Wall
from hypertuna.fe.measure import measure
from hypertuna.fe.mesh import MeshSize, mesh_size
from hypertuna.fe.model import FeOptions, equilibrium, fe_model
from hypertuna.fe.newton import Equilibrium

__all__ = [
    "ANGLES",
    "Case",
    "beam_cases",
    "cube_cases",
    "hose_cases",
    "joint_cases",
    "muscle_cases",
    "sleeve_cases",
    "validate",
]

ANGLES = (25.0, 35.0, 45.0, 60.0)  # deg, of the braid at rest
PRESSURE = 250e3  # Pa
INEXTENSIBLE = 1e8  # N/m, of the braid: theory takes it as infinite
SLACK = 1e-3  # stiffness of slack fibers over taut ones: it alone keeps a braid in shape before pressure tightens it
CARRIED = 1e-3  # m, thickness of the solid that carries a wall
SLEEVE = 1e-3  # m, thickness of the sleeve of matrix
POISSON = (0.475, 0.499)  # the paper's, and nearly incompressible
INCOMPRESSIBLE = 0.4999  # Poisson's ratio that stands for 1/2, where theory has it
HALF, FREE = "contraction at half force", "free contraction"  # names of cases
STRAIN = 0.5  # of the cubes
LINEAR = 0.3  # Poisson's ratio for the linear law: in biaxial tension it has no solution near 1/2


@dataclass(frozen=True)
class Case:
    """A number that theory knows."""

    group: str  # heading below which it is printed
    name: str  # what was computed
    computed: float  # in the unit of the case
    theory: float  # in the unit of the case
    unit: str
    tolerance: float  # largest relative difference of the two that passes [1]
    # whether the elements are known to lock: the case then passes only if the tolerance is exceeded
    locks: bool = False
    text: str = ""  # how the computation failed, empty if it did not

    @property
    def difference(self) -> float:
        """Return (computed - theory) / theory [1]."""
        return self.computed / self.theory - 1

    @property
    def passed(self) -> bool:
        """Return whether the two agree within the tolerance, or differ by more where elements lock."""
        return not self.text and (abs(self.difference) <= self.tolerance) != self.locks


def validate(robot: Robot, progress: Callable[[int, int], None] | None = None) -> tuple[Case, ...]:
    """Compute all cases. `robot` [drive_unit]."""
    tubes = (muscle_cases(robot, math.radians(angle), hose=hose) for hose in (False, True) for angle in ANGLES)
    groups = (*tubes, sleeve_cases(robot), hose_cases(robot), beam_cases(robot), cube_cases(robot), joint_cases(robot))
    found: list[Case] = []
    for k, group in enumerate(groups):
        if progress is not None:
            progress(k, len(groups))
        found += group
    return tuple(found)


def muscle_cases(robot: Robot, angle: float, *, hose: bool) -> Iterator[Case]:
    """Compare a free McKibben tube with theory: blocked force, and contraction under half of it and under none.

    A braid alone is compared with the textbook, `ideal_pull`; with the hose in it, with core muscle.hpp.

    `angle` [rad].
    """
    wall = replace(_wall(robot, angle), hose=mooney(robot, drive_unit(robot).hose) if hose else Mooney(0.0, 0.0))
    group = f"Tube, braid {'and hose' if hose else 'alone'}, {math.degrees(angle):g} deg"
    blocked = ideal_pull(PRESSURE, wall.outer, angle)
    unit = _unit(wall, CARRIER, 0.0)  # without a sleeve
    if not hose:
        held = tube(wall, thickness=CARRIED, held=True)
        text = _text(load(held, PRESSURE))
        yield Case(group, "blocked force", pull(held), blocked, "N", 0.003, text=text)
    free = tube(wall, thickness=CARRIED)
    for part, name in ((0.5, HALF), (0.0, FREE)):
        text = _text(load(free, PRESSURE, part * blocked))
        theory = _stretch(unit, part * blocked) if hose else ideal_stretch(angle, part)
        yield Case(group, name, 1 - free.stretch, 1 - theory, "1", 0.01, text=text)


def sleeve_cases(robot: Robot) -> Iterator[Case]:
    """Compare a tube with hose and a sleeve of matrix, as in a joint, with core muscle.hpp."""
    wall = _wall(robot, drive_unit(robot).braid_angle)
    sleeve = Solid("mooney_rivlin", mooney(robot, drive_unit(robot).matrix), POISSON[1])
    group = f"Tube, hose in matrix, {math.degrees(wall.braid_angle):g} deg"
    unit, free = _unit(wall, sleeve, SLEEVE), tube(wall, sleeve, thickness=SLEEVE)
    bar = sleeve.constants, math.pi * ((wall.outer + SLEEVE) ** 2 - wall.outer**2)
    blocked = ideal_pull(PRESSURE, wall.outer, wall.braid_angle)
    for part, name in ((0.5, HALF), (0.0, FREE)):
        text = _text(load(free, PRESSURE, part * blocked))
        yield Case(group, name, 1 - free.stretch, 1 - _stretch(unit, part * blocked, bar), "1", 0.01, text=text)


def hose_cases(robot: Robot) -> Iterator[Case]:
    """Compare a muscle whose hose is solid elements with core muscle.hpp and with the wall's energy per outer area."""
    wall = _wall(robot, drive_unit(robot).braid_angle)
    sleeve = Solid("mooney_rivlin", mooney(robot, drive_unit(robot).matrix), POISSON[1])
    blocked = ideal_pull(PRESSURE, wall.outer, wall.braid_angle)
    unit, bar = _unit(wall, sleeve, SLEEVE), (sleeve.constants, math.pi * ((wall.outer + SLEEVE) ** 2 - wall.outer**2))
    solid = resolved_hose(wall, sleeve, thickness=SLEEVE, poisson=INCOMPRESSIBLE)
    thin = tube(wall, sleeve, thickness=SLEEVE)
    for part, name in ((0.5, HALF), (0.0, FREE)):
        text = _text(load(solid, PRESSURE, part * blocked))
        short, core = 1 - solid.stretch, 1 - _stretch(unit, part * blocked, bar)
        yield Case("Hose of solid elements", f"{name}, core", short, core, "1", 0.01, text=text)
        text += _text(load(thin, PRESSURE, part * blocked))
        yield Case("Hose of solid elements", f"{name}, wall", short, 1 - thin.stretch, "1", 0.01, text=text)


def beam_cases(robot: Robot) -> Iterator[Case]:
    """Compare a clamped beam of the matrix with Timoshenko's theory, for several orders of elements."""
    forms = ((1, 1.0), (1, 0.5), (2, 0.5), (3, 1.0), (4, 1.0))
    for poisson in POISSON:
        solid = Solid("mooney_rivlin", mooney(robot, drive_unit(robot).matrix), poisson)
        for order, size in forms:
            sag, theory, elements, found = cantilever(solid, order=order, size=size)
            name = f"{elements} elements, order {order}"
            locks = order == 1
            tolerance = 0.5 if locks else 0.03
            group = f"Cantilever, nu = {poisson:g}"
            yield Case(group, name, 1e3 * sag, 1e3 * theory, "mm", tolerance, locks, _text(found))


def cube_cases(robot: Robot) -> Iterator[Case]:
    """Compare the nominal stress of a cube with closed forms, for every law of the matrix.

    Those of the hyperelastic laws are of an incompressible solid.
    """
    shear = 2 * sum(mooney(robot, drive_unit(robot).matrix))
    constants = Mooney(0.4 * shear, 0.1 * shear)  # both terms, at the shear modulus of the matrix
    for law in LAWS:
        solid = Solid(law, constants, LINEAR if law == "linear" else INCOMPRESSIBLE)
        for strain in STRAINS:
            amount = STRAIN if strain != "biaxial" else STRAIN / 2
            stress, found = cube_stress(solid, strain, amount)
            theory, name = closed_form(solid, strain, amount), f"{strain}, strain {amount:g}"
            group = f"Cube, {law.replace('_', '-')}"
            yield Case(group, name, stress / 1e3, theory / 1e3, "kPa", 0.001, text=_text(found))


def joint_cases(robot: Robot, *, pressure: float = 50e3) -> Iterator[Case]:
    """Compare the last joint's bend with that of displacements of a lower order, and at a higher Poisson's ratio.

    `pressure` [Pa].
    """
    joint = robot.joints[-1].name

    def bend(mesh: str | MeshSize = "coarse", poisson: float = 0.49) -> tuple[float, str]:
        model = fe_model(robot, joint, FeOptions(poisson=poisson, mesh=mesh))
        text = _text(equilibrium(model, pressure=(pressure, 0.0)))
        return math.degrees(measure(model).angle), text

    group = f"Bend of joint {joint}, {pressure / 1e3:g} kPa"
    bent, text = bend()
    for name, (angle, why) in (
        ("order 3 on medium against order 4 on coarse", bend(replace(mesh_size("medium"), order=3))),
        (f"nu {POISSON[1]:g} against 0.49", bend(poisson=POISSON[1])),
    ):
        yield Case(group, name, angle, bent, "deg", 0.03, text=text or why)


def _wall(robot: Robot, angle: float) -> Wall:
    """Return a robot's hose and braid with another braid angle [rad] and fibers that do not stretch."""
    unit = drive_unit(robot)
    hose = mooney(robot, unit.hose)
    return Wall(unit.outer_diameter / 2, unit.inner_diameter / 2, hose, angle, INEXTENSIBLE, SLACK)


def _unit(wall: Wall, sleeve: Solid, thickness: float) -> _core.DriveUnit:
    """Make the muscle of core muscle.hpp."""
    return _core.DriveUnit(
        outer=2 * wall.outer,
        inner=2 * wall.inner,
        tan2=math.tan(wall.braid_angle) ** 2,
        sleeve=thickness,
        hose=wall.hose,
        matrix=sleeve.constants,
        friction=0.0,
    )


def _stretch(unit: _core.DriveUnit, force: float, bar: tuple[Mooney, float] | None = None) -> float:
    """Return the stretch at which a muscle pulls with a force [N]; `bar`: constants and area of a sleeve beside it."""
    from scipy.optimize import brentq  # here, because it takes longer to import than most commands take

    def excess(stretch: float) -> float:
        pull = float(unit.at(np.array([stretch]), pressure=PRESSURE)["pull"][0])
        if bar is not None:
            solid, area = bar
            pull += 2 * area * (solid.c1 * (stretch - stretch**-2) + solid.c2 * (1 - stretch**-3))
        return pull - force

    return float(brentq(excess, 0.5, unit.closing_stretch(LUMEN_MIN), xtol=1e-12))


def _text(found: Equilibrium) -> str:
    """Return why loads were not reached, empty if they were."""
    return "" if found.converged else found.text
