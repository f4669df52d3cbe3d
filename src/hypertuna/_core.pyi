"""
The numerical core: SI units and radians throughout, plain arrays in and out.
"""

from collections.abc import Mapping, Sequence
from typing import Annotated

import numpy
from numpy.typing import NDArray

class Model:
    """A robot in its water, ready for the core. Immutable."""

    def __init__(
        self,
        *,
        law: str,
        cross_flow: bool,
        length: float,
        joint_group: Sequence[int],
        joint_share: Sequence[float],
        columns: Mapping[str, Sequence[float]],
    ) -> None:
        """
        Joint i sits at the front of link i; its group is -1 where it is rigid. `columns` holds the parameters after the gait's, by the names of `parameter_names`; there are as many groups as bandwidths.
        """

    @property
    def links(self) -> int:
        """Number of links."""

    @property
    def groups(self) -> int:
        """Number of joint groups."""

    def parameter_names(self) -> list[str]:
        """
        Names of all parameters in the order of the derivatives: the gait's, the joints', the links', the water's.
        """

def isa() -> str:
    """Name of the instruction set in use."""

def isas() -> list[str]:
    """Names of the instruction sets that this build and this processor have."""

def lanes() -> int:
    """Gaits that one instruction serves."""

def settle(
    model: Model,
    frequency: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    amplitude: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    phase: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    bias: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    *,
    steps: int,
    wait: int,
    most_beats: int,
    threads: int,
) -> NDArray[numpy.float64]:
    """
    Settled beats of many gaits, one row each, columns as named by `settle_columns`: by Newton's method, or (wait >= 0) by so many beats from rest.
    """

def gradient(
    model: Model,
    frequency: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    amplitude: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    phase: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    bias: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    momentum: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    directions: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    *,
    steps: int,
    threads: int,
) -> NDArray[numpy.float64]:
    """
    Derivatives of one beat of each gait from its momentum at the start: (gaits, `gradient_outputs`, 3 + directions), by that momentum and along `directions` (parameters, directions).
    """

def track(
    model: Model,
    joints: Annotated[NDArray[numpy.float64], dict(shape=(None, None, None), order="C", device="cpu", writable=False)],
    directions: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    *,
    step: float,
) -> dict[str, NDArray[numpy.float64]]:
    """
    Swim a joint motion, given at every half step (2 steps + 1, links, 3), from rest in the water: pose of the nose at every step, its rate, and its derivatives along `directions` (parameters, directions).
    """

def settle_columns() -> list[str]:
    """Names of the columns of `settle`."""

def gradient_outputs() -> list[str]:
    """Names of the outputs of `gradient`."""

SETTLED_DISTANCE: float = 1e-07

def joint_motion(
    model: Model,
    *,
    frequency: float,
    amplitude: Sequence[float],
    phase: Sequence[float],
    bias: Sequence[float],
    clock: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
) -> NDArray[numpy.float64]:
    """
    Angle, rate and acceleration of every joint (instants, links, 3) where 2 pi f t is `clock`.
    """

def dynamics(
    model: Model,
    joints: Annotated[NDArray[numpy.float64], dict(shape=(None, None, None), order="C", device="cpu", writable=False)],
    twist: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
) -> dict[str, NDArray[numpy.float64]]:
    """
    The equations of swimming at given states, joints (states, links, 3) and twist (states, 3): inertia (3, 3), momentum, acceleration, wrench of the water, joint torque, loss to the water and kinetic energy.
    """

def advance(
    model: Model,
    joints: Annotated[NDArray[numpy.float64], dict(shape=(None, None, None), order="C", device="cpu", writable=False)],
    *,
    step: float,
    twist: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    pose: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
) -> dict[str, NDArray[numpy.float64]]:
    """
    Swim a joint motion, given at every half step (2 steps + 1, links, 3), from a twist and a pose: twist, pose, joint torque, loss to the water and kinetic energy at every step.
    """

ATMOSPHERE: float = 101325.0

def circuit_columns() -> list[str]:
    """Numbers that describe a circuit, in the order of a row."""

def displaced(
    circuit: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    angle: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
) -> NDArray[numpy.float64]:
    """
    Volume that a cylinder pushes out when its servo turns from zero to an angle, and its derivative by the angle [m^3, m^3/rad].
    """

def run_circuit(
    circuit: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    start: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    target: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    unit_space: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    supply: float,
    interval: float,
    steps: int,
) -> dict[str, NDArray[numpy.float64]]:
    """
    Run a circuit: its servo follows targets held for an interval each, in Runge-Kutta steps, while the volume of its units goes straight from one given value to the next. State and what is seen of it at every interval.
    """

def circuit_stiffness(
    circuit: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    pressure: float,
    flow: float,
) -> float:
    """
    Bound of a circuit's rates with the joint held, at a pressure and a flow [1/s]: Runge-Kutta steps must be shorter than 2.7 over it.
    """

def battery_columns() -> list[str]:
    """Numbers that describe a battery, in the order of a row."""

def battery_output(
    battery: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    taken: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    power: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
) -> NDArray[numpy.float64]:
    """
    Voltage and current of a battery and voltage at the servos, after a charge was taken, while they draw a power [V, A, V].
    """
