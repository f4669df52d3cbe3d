"""
The numerical core: SI units and radians throughout, plain arrays in and out.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Annotated, Any, overload

import numpy
from numpy.typing import NDArray

IMAGE_VERSION: int = 6

def water_laws() -> list[tuple[str, list[tuple[str, str, bool]]]]:
    """
    The water laws, each with the columns of its coefficients: name, unit, whether one value per link.
    """

class Model:
    """A robot in its water, ready for the core. Immutable."""

    def __init__(self, law: str, columns: dict[str, Any]) -> None:
        """
        From `body_length` [m], `joint_group` and `joint_share` (links: joint i is at the front of link i, its group is -1 where it is rigid), the law's flags (0 or 1), and the parameters after the gait's, by the names of `parameter_names`; there are as many groups as bandwidths.
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

def yield_settle(
    model: Model,
    hinges: Sequence[int],
    spring: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    frequency: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    amplitude: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    phase: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    bias: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    *,
    steps: int,
    wait: int,
    max_beats: int,
    from_rest: int,
    approach: int,
    mass: float,
    threads: int,
) -> NDArray[numpy.float64]:
    """
    As `settle` for a body whose joints at the fronts of the links `hinges` yield, head to tail, `spring` (gaits, hinges x spring_columns) being the numbers of each: the named columns, state, monodromy, then of each hinge mean, sine and cosine of its swing from rest, peak of its angle, and its damper's power.
    """

def yield_gradient(
    model: Model,
    hinges: Sequence[int],
    spring: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    frequency: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    amplitude: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    phase: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    bias: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    state: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    directions: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    *,
    steps: int,
    mass: float,
    threads: int,
) -> NDArray[numpy.float64]:
    """As `gradient`, the springs' numbers being the last parameters."""

def yield_bends(
    model: Model,
    hinges: Sequence[int],
    spring: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    frequency: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    amplitude: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    phase: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    bias: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    state: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    *,
    steps: int,
    count: int,
) -> NDArray[numpy.float64]:
    """
    Angle, rate and acceleration (count, hinges, 3) of hinges at every step from a state on.
    """

def spring_columns() -> list[str]:
    """Numbers of a hinge's spring, in the order of a row."""

def hinge_inertia(model: Model, hinges: Sequence[int]) -> NDArray[numpy.float64]:
    """
    Inertia that the free, straight body opposes to the joints at the fronts of the links `hinges` [kg m^2].
    """

def spring_steps(
    model: Model,
    hinges: Sequence[int],
    spring: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    frequency: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    steps: int,
) -> list[int]:
    """
    Steps of a beat at each frequency [Hz] that follow the springs (hinges, spring_columns): `steps`, doubled as often as it takes; 0 where not even `MOST_SPRING_STEPS` do.
    """

MOST_SPRING_STEPS: int = 1024

BENT: float = 0.5

COMPRESSED: float = 0.1

MAX_HINGES: int = 3

YIELD_LINKS: int = 32

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
    max_beats: int,
    from_rest: int,
    approach: int,
    mass: float,
    threads: int,
) -> NDArray[numpy.float64]:
    """
    Settled beats of many gaits, one row each, columns as named by `settle_columns`: by Newton's method from a brisk speed, from the motion after `from_rest` beats from rest (>= 0), or by `wait` beats from rest (>= 0). With `approach` > 0 a start from rest is followed toward each for at most `approach` beats. `mass` [kg] is the whole body's.
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
    mass: float,
    threads: int,
) -> NDArray[numpy.float64]:
    """
    Derivatives of settled beats, from their momentum at the start, along `directions` (parameters and links' shares, directions): (gaits, differentiable quantities, directions); NaN where the start is not determined.
    """

def track(
    model: Model,
    joints: Annotated[NDArray[numpy.float64], dict(shape=(None, None, None), order="C", device="cpu", writable=False)],
    directions: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    *,
    step: float,
    twist: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)]
    | None = None,
    rates: bool = False,
) -> dict[str, NDArray[numpy.float64]]:
    """
    Swim a joint motion, given at every half step (2 steps + 1, links, 3), from rest in the water or from a twist (3,) of the head: pose of the nose at every step, its rate, and its derivatives along `directions` (parameters, directions), after those by the twist if it is given; with `rates` those of the rate, too.
    """

def held(
    model: Model,
    frequency: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    amplitude: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    phase: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    bias: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    speed: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    directions: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    *,
    steps: int,
    threads: int,
) -> NDArray[numpy.float64]:
    """
    Mean force toward the head [N] over a beat of each gait whose head is held on a straight path at `speed` [m/s], and its derivatives along `directions` (parameters, directions): (gaits, 1 + directions).
    """

def settle_columns() -> list[str]:
    """Names of the columns of `settle`."""

def quantities() -> list[tuple[str, str, str, str, int, int, bool]]:
    """
    Quantities of a settled beat: name, unit, label, meaning, how far it is shown (0 in data sets, 1 in records, 2 in summaries), what is better (0 neither, 1 large, 2 small), and whether it has derivatives.
    """

SETTLED_DISTANCE: float = 1e-07

BEAT_STEPS: int = 128

NEWTON_BEATS: int = 60

APPROACH_BEATS: int = 2000

NEUTRAL: float = 1.000001

NEARLY_STRAIGHT: float = 1000.0

STATE_SIZE: int = 3

def verdict(status: int, beats: float, distance: float, spectral_radius: float, turn: float) -> str:
    """
    The verdict on a beat that turns the body by `turn` [rad], in words; `status` is one of `beat_statuses`.
    """

def beat_statuses() -> list[str]:
    """Names of the statuses of a search for a settled beat."""

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

class DriveUnit:
    """A McKibben muscle. Immutable."""

    def __init__(
        self,
        *,
        outer: float,
        inner: float,
        tan2: float,
        sleeve: float,
        hose: tuple[float, float],
        matrix: tuple[float, float],
        friction: float,
    ) -> None:
        """
        Diameters at rest, squared tangent of the braid's angle, thickness of matrix around, C1 and C2 of hose and matrix.
        """

    def at(
        self,
        stretch: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
        *,
        pressure: float,
    ) -> dict[str, NDArray[numpy.float64]]:
        """
        Energy and lumen per length at rest with their slopes, pull, pull by the printed equations, pressure that the walls carry and contact area, at every stretch.
        """

    def closing_stretch(self, left: float) -> float:
        """Stretch at which this part of the lumen at rest is left."""

class SoftJoint:
    """A soft joint: muscles on both sides of sections of matrix. Immutable."""

    def __init__(
        self,
        unit: DriveUnit,
        *,
        units: float,
        lever: tuple[float, float],
        sections: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
        axis: tuple[float, float],
    ) -> None:
        """
        Muscles a side, lever of each side; length, area, second moment and thickness around a hose of each section; of what lies on the axis, its stiffness and the compressive strain at which it buckles.
        """

    def with_law(
        self, *, printed: bool, nominal_stress: bool, inner_balance: bool, passive: bool, shortens: bool
    ) -> SoftJoint:
        """The same joint by other equations."""

    def bend(
        self,
        pressure: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    ) -> NDArray[numpy.float64]:
        """
        Angle and strain of each section (times, sections, 2) along a path of the two sides' pressures (times, 2) from rest.
        """

    def one_section(self, *, left: float, right: float) -> list[float]:
        """
        Length, area, second moment and thickness around a hose of the one section that stands for all under these pressures.
        """

def joint_columns() -> list[str]:
    """Numbers that describe a joint of one section, in the order of a row."""

def joint_load(
    joint: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    *,
    angle: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    strain: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    pressure: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
) -> dict[str, NDArray[numpy.float64]]:
    """
    Energy, moment, axial force, volumes and friction at every bend, strain relative to the filled joint, and pair of pressures.
    """

def hold_joint(
    joint: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    *,
    angle: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    fill: float,
    lowest: float,
) -> dict[str, NDArray[numpy.float64]]:
    """
    Strain, pressures around the filling one, and volumes that hold every angle.
    """

def balance_joint(
    joint: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    *,
    pressure: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    moment: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
) -> dict[str, NDArray[numpy.float64]]:
    """
    Angle, strain and volumes under pressures (n, 2) and moments of the surroundings (n,).
    """

ATMOSPHERE: float = 101325.0

SERVO_LOOP_RATE: float = 9.762649804303567

def circuit_columns() -> list[str]:
    """Numbers that describe a circuit, in the order of a row."""

def displaced(
    circuit: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    angle: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
) -> NDArray[numpy.float64]:
    """
    Volume that a cylinder pushes out when its servo turns from zero to an angle, and its derivative by the angle [m^3, m^3/rad].
    """

def run_pair(
    circuits: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    joint: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    *,
    target: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    supply: float,
    interval: float,
    steps: int,
) -> dict[str, NDArray[numpy.float64]]:
    """
    Run the two circuits of a joint in air from rest: servo targets are held for an interval each, in Runge-Kutta steps, and the joint, without mass, bends to where silicone and oil balance. What is seen at every interval, with one column per side.
    """

def circuit_stiffness(
    circuit: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    pressure: float,
    flow: float,
) -> float:
    """
    Bound of a circuit's rates with the joint held, at a pressure and a flow [1/s]: Runge-Kutta steps must be shorter than 2.7 over it.
    """

def axle_stiffness(
    circuit: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    mobility: float,
) -> float:
    """
    Bound of the rates of a circuit's servo on the axle of a joint with a mobility [rad/s^2 per N m, 1/s].
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

MAX_JOINTS: int = 12

MAX_COORDINATES: int = 13

MAX_SERVOS: int = 26

def fault_kinds() -> list[str]:
    """Kinds of sensor faults, none first."""

def channel_table() -> list[tuple[str, str, str, str, str, str, str, bool, int, int]]:
    """
    Kinds of sensors in the order of their channels: name, part that fails as one, column of logs, unit, meaning, what has one (joint, circuit, robot), converter (analog, digital, none), whether only the pilot reads it, first channel, channels reserved.
    """

def condition_table() -> list[tuple[str, str, str]]:
    """
    Conditions of the controller's status in the order of its bits: name, what a bit of its place stands for (robot, joint, circuit, servo), sentence.
    """

class LiveController:
    """The controller on board with its state, in double precision."""

    def __init__(self, columns: dict[str, Any]) -> None:
        """At rest, from the columns of hypertuna.control.controller_columns."""

    def step(
        self,
        readings: Mapping[str, Sequence[float]],
        command: Mapping[str, Sequence[float]],
        *,
        fresh: bool = True,
        armed: bool = True,
    ) -> dict[str, Any]:
        """
        One tick: servo pulses [s], their angles [rad], bends set [rad], valid pressures [Pa], and the status: flags with one bit per condition, and where it holds.
        """

class Sensors:
    """The sensors of a robot with what they get wrong."""

    def __init__(self, columns: dict[str, Any], seed: int) -> None:
        """From the columns of hypertuna.sensing.sensor_columns."""

    def read(
        self, truth: Mapping[str, Sequence[float]], faults: Sequence[tuple[str, int, int, float, float]] = []
    ) -> dict[str, list[float]]:
        """
        Readings of a tick for the true values; faults as (kind, first channel, last channel, start, end) [s].
        """

MAX_GAITS: int = 12

def mode_table() -> list[tuple[str, str]]:
    """Modes of the pilot in the order of their numbers: name and sentence."""

def reason_table() -> list[tuple[str, str]]:
    """Reasons of the pilot in the order of their bits: name and sentence."""

def ending_table() -> list[tuple[str, str]]:
    """Ends of a flight in the order of their numbers: name and sentence."""

def ending(mode: int, reasons: int) -> int:
    """How a flight ends in a mode of the pilot: place in `ending_table`."""

def onboard_fields(joints: int, gaits: int) -> list[tuple[str, str, int]]:
    """
    Every number of controller, pilot, mission and limits in the order that core and firmware take them in: part, column, index.
    """

class Pilot:
    """The pilot on board with its mission and state, in double precision."""

    def __init__(self, controller: LiveController, columns: dict[str, Any], mission: dict[str, Any]) -> None:
        """
        At the start of a mission, from the columns of hypertuna.control.guidance.
        """

    def fly(self, readings: Mapping[str, Sequence[float]]) -> dict[str, Any]:
        """
        One tick: pulses [s], command, estimate, mode and reasons. Readings have `fix` where one came, and may have
        its `accuracy` [m].
        """

GRAVITY: float = 9.81

class World:
    """A bench, the plane of still water, or a sea. Immutable."""

    def __init__(self, columns: dict[str, Any]) -> None:
        """
        From `clamped` (0 or 1: the head is held still), `gaps` (n, 2: times without satellites [s]), `resets` (n: times at which the receiver restarts [s]), `released` (s until which someone holds the robot at its start), and the columns `sea.NAME`, `weather.NAME` and `receiver.NAME`, each of which may be left out: without a sea the plane of still water.
        """

class Body:
    """What of a robot moves in the water. Immutable."""

    def __init__(self, model: Model, columns: dict[str, Any]) -> None:
        """
        From `share` (links, D) of which each front joint takes of D coordinates; to be at sea, too, `link.NAME` (links), `fin.NAME`, `shedding` and `antenna`.
        """

    def accelerations(
        self,
        world: World,
        *,
        bend: Annotated[
            NDArray[numpy.float64], dict(shape=(None, None, None), order="C", device="cpu", writable=False)
        ],
        twist: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
        pose: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
        moment: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    ) -> NDArray[numpy.float64]:
        """
        Accelerations (states, 6 + D) of the head (linear, then angular, in body axes) and of D coordinates, at bend (states, 2, D: angle and rate), twist (states, 6) and pose (states, 9: position, attitude w x y z, fin angles), under moments (states, D) on the coordinates.
        """

class Plant(Body):
    """All of a robot that obeys physics alone. Immutable."""

    def __init__(self, model: Model, columns: dict[str, Any]) -> None:
        """
        From the columns of Body, `joints`, `joint.NAME` (joints), `circuit.NAME` (2 joints), `battery.NAME`, `idle` [W], and `spring.NAME` of the hinges.
        """

    @property
    def structure(self) -> list[int]:
        """Plants with the same one differ in numbers alone."""

class GaitCommand:
    """A command to a controller. Immutable."""

    def __init__(self, controller: LiveController, columns: dict[str, Any], *, lost_at: float) -> None:
        """
        From `frequency`, `amplitude`, `phase` and `bias` (joints), and `fin` (ticks, 2) at sea, until the command is lost [s].
        """

    @property
    def tick(self) -> float:
        """Control tick [s]."""

def loss_table() -> list[tuple[str, str, str]]:
    """
    Losses of a twin in the order of the power's way to the water: name, what it is taken from, sentence.
    """

@overload
def simulate(
    plant: Plant,
    command: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    world: World,
    *,
    twist: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    tick: float,
    steps: int,
) -> dict[str, NDArray[numpy.float64]]:
    """
    Drive the servos to targets (ticks, 2 joints), each held for a tick, from a twist (6): the record of a run, one row per tick; `ticks` has how many were made.
    """

@overload
def simulate(
    plant: Plant,
    command: GaitCommand,
    world: World,
    *,
    sensors: Sensors,
    faults: Sequence[tuple[str, int, int, float, float]],
    twist: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    pose: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)] | None = None,
    ticks: int,
    steps: int,
    every: int = 1,
) -> dict[str, NDArray[numpy.float64]]:
    """
    Run plant, sensors and controller under one command from a twist (6) and, at sea, a pose (9): the record, one row every `every` ticks. Faults are (kind, first channel, last channel, start, end) [s].
    """

@overload
def simulate(
    plant: Plant,
    command: Pilot,
    world: World,
    *,
    sensors: Sensors,
    faults: Sequence[tuple[str, int, int, float, float]],
    servo_faults: Sequence[tuple[int, float, float, float]],
    oil_losses: Sequence[tuple[int, float, float]],
    twist: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    pose: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    charge: float,
    ticks: int,
    steps: int,
    every: int,
    state: bytes | None = None,
    board: Callable[[Sequence[float], float], Sequence[float]] | None = None,
) -> tuple[dict[str, NDArray[numpy.float64]], bytes]:
    """
    Fly a pilot's mission from its start (twist (6), pose (9), charge taken [C]) or from a state that an earlier part left: the record and the state at the end. `servo_faults` are servos that stand, (servo in the order of the pulses, angle [rad] or NaN for where it is, from, to [s]), `oil_losses` circuits with a hole, (circuit, from, to [s]). `board` takes the pilot's place: a function of what the sensors show (bends, pressures, currents, rates, accelerations, battery, depth, field, and a fix where one came) and of the height of its antenna above the surface [m] that returns the servo pulses [s].
    """

def simulate_batch(
    runs: Sequence[
        tuple[
            Plant,
            GaitCommand,
            World,
            Sensors,
            Sequence[tuple[str, int, int, float, float]],
            Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
        ]
    ],
    *,
    ticks: int,
    steps: int,
) -> list[dict[str, NDArray[numpy.float64]]]:
    """
    Run twins in the plane side by side: (plant, command, world, sensors, faults, twist (6)) each, of robots of the same structure. Records as `simulate` gives them, to the same bits.
    """

def twin_lanes() -> int:
    """Twins that one instruction serves."""

class Batch:
    """Twins in the plane that go on together under commands that may change."""

    def __init__(self, twins: Sequence[tuple[object, LiveController, Sensors, float]], *, steps: int) -> None:
        """
        From (plant, controller, sensors, speed [m/s]) each, of robots of the same structure, at rest.
        """

    def __deepcopy__(self, memo: object) -> Batch:
        """A batch that goes on from the same state."""

    def restart(self, twin: int, start: tuple[object, LiveController, Sensors, float]) -> None:
        """Begin one anew, perhaps of another robot."""

    def command(
        self,
        frequency: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
        amplitude: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
        phase: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
        bias: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    ) -> None:
        """
        From now on, of each twin: frequency [Hz]; amplitudes, phases and biases (twins, joints) [rad].
        """

    def advance(self, ticks: int, threads: int = 1) -> None:
        """Make control ticks."""

    def columns(self) -> dict[str, NDArray[numpy.float64]]:
        """
        State now and last tick by the names of `simulate`, one row per twin; `energy`, electrical, drawn since the start [J]; and `lost`, 1 where the state is none that a robot can have.
        """

def refusal_table() -> list[tuple[str, str]]:
    """
    Refusals of the firmware in the order of their numbers: name and sentence.
    """

def fault_table() -> list[tuple[str, str, str, bool, bool, str, str]]:
    """
    Faults that the firmware knows in the order of their bits: name, sentence, answer, whether it is latched until the robot is armed again, whether it forbids arming, its severity, and the parameter that may choose another answer.
    """

def answer_table() -> list[str]:
    """
    Answers to a fault that a parameter may choose, in the order of their numbers.
    """

def record_fields(joints: int) -> list[tuple[str, bool, int]]:
    """
    Fields of a black box record of a tick, in order: name, whether it is a float, and count. A field with four names has a byte for each.
    """

BOARD_JOINTS: int = 4

BOARD_SERVOS: int = 10

MAX_PARAMETERS: int = 128

RECORD_MARK: int = 2970353664

RECORD_ROBOT: int = 1

RECORD_TICK: int = 2

RECORD_LAYOUT: int = 2548875705

def state_table() -> list[tuple[str, str, str]]:
    """
    States of the robot in the order of their numbers: name, sentence, and the order that selects it as a mode.
    """

def order_table() -> list[tuple[str, str, str, list[str], list[str]]]:
    """
    Orders and events of the firmware: name, sentence, who gives it, what must hold, and for each state the next one, an empty string where it does not change, `back` for the one before, or `!` and the refusal.
    """

def need_table() -> list[tuple[str, str]]:
    """What must hold for an order to change the state: name and sentence."""

MODE_BASE: int = 100

def fit_silhouette(
    pixels: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    length: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    share: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    section: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    start: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    mean: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    precision: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    stages: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    loss: float,
    iterations: int,
) -> dict[str, NDArray[numpy.float64]]:
    """
    Fit the silhouette of a chain to pixels (m, 5): x, y, lean of the sight, value.
    """

def draw_silhouette(
    pixels: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    length: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    share: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    section: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order="C", device="cpu", writable=False)],
    unknowns: Annotated[NDArray[numpy.float64], dict(shape=(None,), order="C", device="cpu", writable=False)],
    edge: float,
) -> dict[str, NDArray[numpy.float64]]:
    """Draw the silhouette: values, derivatives, distances inside its edge."""
