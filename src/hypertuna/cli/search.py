"""The options of a search for gaits, shared by `optimize`, `optimize ask` and `pareto`."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Annotated, Any, TypeVar

import numpy as np

from hypertuna.cli import options as opt
from hypertuna.cli.parsing import Bound
from hypertuna.description.robot import Robot
from hypertuna.errors import InputError
from hypertuna.optimization.constraints import Limit, gait_limits
from hypertuna.optimization.optimize import METHODS
from hypertuna.ranges import POSITIVE

T = TypeVar("T")
positive = partial(opt.number, limits=POSITIVE)  # an option of a limit


@dataclass(frozen=True)
class SearchOptions:
    """Options: an objective, and the search for its best gait."""

    maximize: Annotated[
        str | None, opt.text("--maximize", "Quantity to maximize, such as speed or efficiency.", "NAME")
    ] = None
    minimize: Annotated[
        str | None, opt.text("--minimize", "Quantity to minimize, such as cost_of_transport.", "NAME")
    ] = None
    speed: Annotated[
        float | None, opt.number("--speed", "m/s", "Expected speed in m/s, at low cost of transport (Eq. 42).")
    ] = None
    weight: Annotated[
        float | None,
        opt.number(
            "--weight",
            "m/s per J/(kg m)",
            "k of Eq. 42 in m/s per J/(kg m). (default: small enough to reach the expected speed)",
        ),
    ] = None
    method: Annotated[
        str | None,
        opt.word("--method", tuple(METHODS), "Optimizer. (default: gradient; without derivatives pso)"),
    ] = None
    particles: Annotated[
        int | None,
        opt.whole_number("--particles", "Gaits per batch; starts of the gradient search. (default: 15; gradient 6)"),
    ] = None
    iterations: Annotated[
        int | None, opt.whole_number("--iterations", "Maximum number of batches. (default: 60; cma 200)")
    ] = None
    bounds: opt.Bounds = None
    seed: opt.Seed = 1

    def arguments(self) -> dict[str, Any]:
        """Return the options as arguments of `optimize`."""
        chosen = [f"--{key}" for key in ("maximize", "minimize", "speed") if getattr(self, key) is not None]
        if len(chosen) != 1:
            rule = "must be one of --maximize, --minimize and --speed"
            fix = "give --maximize speed, --speed 0.4 or --minimize cost_of_transport"
            raise InputError(rule, key="the objective", value=" and ".join(chosen) or "missing", fix=fix)
        return vars(self) | {"bounds": bounds_of(self.bounds)}


@dataclass(frozen=True)
class RobustOptions:
    """Options: whether the objective is a mean over sampled robots; keywords of `optimize` and `pareto`."""

    robust: Annotated[
        str | None,
        opt.text(
            "--robust",
            "Optimize the mean of the objective, or of its worst 5 % (worst5), over robots sampled from the fit.",
        ),
    ] = None
    samples: Annotated[int, opt.whole_number("--samples", "Number of robots to sample, with --robust.")] = 32


@dataclass(frozen=True)
class GaitLimits:
    """Options: limits that depend on the gait alone."""

    max_joint_rate: Annotated[
        float | None, positive("--max-joint-rate", "deg/s", "Maximum rate of a joint group in deg/s.")
    ] = None
    amplitude_by_bandwidth: Annotated[
        bool,
        opt.flag("--amplitude-by-bandwidth", "Limit amplitudes to those that the joints' bandwidth lets them reach."),
    ] = False

    def make(self, robot: Robot, **limits: Any) -> tuple[Limit, ...]:
        """Return the limits; `limits` are further arguments of `gait_limits`, in SI units."""
        rate = None if self.max_joint_rate is None else float(np.radians(self.max_joint_rate))
        return gait_limits(robot, joint_rate=rate, amplitude_by_bandwidth=self.amplitude_by_bandwidth, **limits)


@dataclass(frozen=True)
class SwimLimits(GaitLimits):
    """Options: limits on a gait, and on the torques and Strouhal number of its swim."""

    max_torque: Annotated[float | None, positive("--max-torque", "N m", "Maximum torque of a joint in N m.")] = None
    strouhal: Annotated[Sequence[float] | None, opt.interval("--strouhal", "1", "Range of the Strouhal number.")] = None

    def make(self, robot: Robot, **limits: Any) -> tuple[Limit, ...]:
        """Return the limits; `limits` are further arguments of `gait_limits`, in SI units."""
        return super().make(robot, torque=self.max_torque, strouhal=self.strouhal, **limits)


Design = Annotated[
    list[Bound] | None,
    opt.bound(
        "--design",
        "the unit of the file",
        "Bounds of a number of the robot's file, such as hinge.stiffness=0.05:2, or of a factor on the caudal fin: "
        "fin.span, fin.chord, fin.area, fin.aspect_ratio; repeatable.",
    ),
]


@dataclass(frozen=True)
class BodyLimits:
    """Options: limits on the body of a design."""

    max_mass: Annotated[float | None, positive("--max-mass", "kg", "Maximum mass of the robot in kg.")] = None
    max_length: Annotated[float | None, positive("--max-length", "m", "Maximum length of the robot in m.")] = None
    max_bend: Annotated[
        float | None, positive("--max-bend", "deg", "Maximum angle of each passive hinge in degrees.")
    ] = None

    def arguments(self, robot: Robot) -> dict[str, float | None]:
        """Return the limits as arguments of `gait_limits`."""
        if self.max_bend is not None and not robot.hinges:
            fix = "leave it out, or add the table [hinge]"
            raise InputError("needs a passive hinge, which the robot lacks", key="--max-bend", fix=fix)
        bend = None if self.max_bend is None else float(np.radians(self.max_bend))
        return {"mass": self.max_mass, "length": self.max_length, "bend": bend}


def design_of(bounds: Sequence[Bound] | None) -> dict[str, tuple[float, float]]:
    """Return low and high of each variable of --design, by key."""
    return once([(name, (low, high)) for name, low, high in bounds or []])


def once(pairs: Sequence[tuple[str, T]]) -> dict[str, T]:
    """Return the pairs of --design as a dictionary; refuse a key that is given twice."""
    for name, count in Counter(name for name, _ in pairs).items():
        if count > 1:
            raise InputError("must be given once", key=f"--design {name}", value=f"{count} times", fix="leave one out")
    return dict(pairs)


def bounds_of(bounds: Sequence[Bound] | None) -> dict[str, tuple[float, float]]:
    """Return bounds as pairs of low and high by name."""
    return {name: (low, high) for name, low, high in bounds or []}
