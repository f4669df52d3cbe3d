"""The options of a search for gaits, shared by `optimize`, `optimize ask` and `pareto`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated

import numpy as np
import typer

from hypertuna.cli import options as opt
from hypertuna.cli import parsing
from hypertuna.description.robot import Robot
from hypertuna.optimization.constraints import Limit, gait_limits

SearchRobot = Annotated[
    str | None, opt.text("--robot", "Name of a robot that comes with hypertuna, or path of its file.")
]
Maximize = Annotated[str | None, opt.text("--maximize", "Quantity to maximize: speed, efficiency ...")]
Minimize = Annotated[str | None, opt.text("--minimize", "Quantity to minimize: cost_of_transport ...")]
Speed = Annotated[
    float | None, opt.number("--speed", "m/s", "Expected speed in m/s, at low cost of transport (Eq. 42).")
]
Weight = Annotated[
    float | None,
    opt.number(
        "--weight",
        "m/s per J/(kg m)",
        "k of Eq. 42 in m/s per J/(kg m). (default: small enough to reach the expected speed)",
    ),
]
Method = Annotated[str, opt.text("--method", "pso, cma, gradient or de.")]
Particles = Annotated[
    int | None,
    opt.whole_number("--particles", "Gaits per batch; starts of the gradient search. (default: 15; gradient 6)"),
]
Iterations = Annotated[
    int | None, opt.whole_number("--iterations", "Maximum number of batches. (default: 60; cma 200)")
]
Robust = Annotated[
    str | None,
    opt.text("--robust", "mean or worst5: the objective over robots sampled from the fit of --robot."),
]
Samples = Annotated[int, opt.whole_number("--samples", "Number of robots to sample, with --robust.")]
Rate = Annotated[float | None, opt.number("--max-joint-rate", "deg/s", "Maximum rate of a joint group in deg/s.")]
Torque = Annotated[float | None, opt.number("--max-torque", "N m", "Maximum torque of a joint in N m.")]
Reach = Annotated[
    bool,
    typer.Option(
        "--amplitude-by-bandwidth", help="Limit amplitudes to those that the joints' bandwidth lets them reach."
    ),
]
Strouhal = Annotated[
    Sequence[float] | None,
    opt.option(
        ("--strouhal",),
        "Range of the Strouhal number.",
        "LOW:HIGH",
        lambda text, key: parsing.interval(text, key, "1"),
    ),
]
MinSpeed = Annotated[float | None, opt.number("--min-speed", "m/s", "Minimum speed in m/s.")]


def limits_of(
    robot: Robot,
    rate: float | None = None,
    torque: float | None = None,
    reach: bool = False,
    strouhal: Sequence[float] | None = None,
    speed: float | None = None,
) -> tuple[Limit, ...]:
    """Make the limits of the options: rate [deg/s], torque [N m], speed [m/s]."""
    return gait_limits(
        robot,
        joint_rate=None if rate is None else float(np.radians(rate)),
        torque=torque,
        amplitude_by_bandwidth=reach,
        strouhal=None if strouhal is None else (strouhal[0], strouhal[1]),
        speed=speed,
    )
