"""Forces on a rectangular plate that heaves and pitches and sheds a wake, by a lattice of vortex rings in time.

    python validation/flow/wake.py [-o FILE]

Potential flow in three dimensions, panels and rings as in fin.py, in the plate's axes: x along the chord from the
leading edge, y along the span, z across. Each step sheds a row of rings with the circulation of the last panels
(Kutta's condition). Its rear line carries what the edge shed during the step: it is left where the edge was half a
step ago and stays there or, if free, moves with the flow. While it is the newest one it lies a quarter of a step
behind, where it acts as the sheet that it stands for (whose effect goes with one over the root of the distance). Force
on the plate: Joukowski's on every bound segment, with the local velocity, and the rate of each ring's impulse,

    F = rho sum(Gamma V x l) - rho sum(dGamma/dt A n)

Its part along the chord is the suction at the leading edge. Units: chord, density of water and any speed.

Prints the tables of README.md: plates of infinite span beside Theodorsen (1935) and Garrick (1936), and the fin of
HyperTuna in the settled beats of Table IV's gaits beside the edge terms of the strip law (6 minutes); -o stores them.
"""

import argparse
import json
import math
import runpy
import shlex
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.special import hankel2

HERE = Path(__file__).parent
FIN = runpy.run_path(str(HERE / "fin.py"))
segment, rings = FIN["segment"], FIN["rings"]
CORE = 0.1  # radius, in chords, within which a vortex's velocity fades, where it moves a free wake
Motion = Callable[[float], np.ndarray]  # time -> x, z of the leading edge, angle


class Wake(NamedTuple):
    """Record of a plate's motion and of the force on it."""

    time: np.ndarray
    speed: np.ndarray  # (n, 3): of the leading edge along x and z of the plate, angular
    force: np.ndarray  # (n, 2): along x and z of the plate, over its area times density
    angle: np.ndarray
    impulse: np.ndarray  # (n, 2): of all rings, along the axes at rest, over area times density
    moment: np.ndarray  # (n,): of the force about the leading edge, as the angle turns, over area times density

    def at_rest(self) -> np.ndarray:
        """Return the force (n, 2) along the axes at rest."""
        return turned(self.force, self.angle)


def turned(vector: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Turn vectors (..., 2) from axes at an angle to those at rest."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * vector[..., 0] - s * vector[..., 1], s * vector[..., 0] + c * vector[..., 1]], axis=-1)


def placed(points: np.ndarray, pose: np.ndarray, *, back: bool = False) -> np.ndarray:
    """Transform points (..., 3) from the plate's axes to those at rest, or back."""
    plane = points[..., ::2] - pose[:2] if back else points[..., ::2]
    plane = turned(plane, -pose[2] if back else pose[2]) + (0 if back else pose[:2])
    return np.stack([plane[..., 0], points[..., 1], plane[..., 1]], axis=-1)


def induced(points: np.ndarray, corners: np.ndarray, core: float = 0.0) -> np.ndarray:
    """Return the velocity (n, m, 3) of unit rings (m, 4, 3) at points (n, 3)."""
    return sum(segment(points, corners[:, k], corners[:, (k + 1) % 4], core) for k in range(4))


def between(lines: np.ndarray) -> np.ndarray:
    """Return the corners (m, 4, 3) of the wake's rings between lines (rows, strips + 1, 3), from the plate backward."""
    front, rear = lines[:-1], lines[1:]
    return np.stack([front[:, :-1], rear[:, :-1], rear[:, 1:], front[:, 1:]], axis=2).reshape(-1, 4, 3)


def area(corners: np.ndarray) -> np.ndarray:
    """Return the area vectors (m, 3) of rings."""
    return np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]) / 2


def velocity(motion: Motion, time: float, step: float) -> np.ndarray:
    """Return the leading edge's speed along x and z of the plate, and the angular speed (3,)."""
    rate = (motion(time + step) - motion(time - step)) / (2 * step)
    return np.append(turned(rate[:2], -motion(time)[2]), rate[2])


def flow(
    motion: Motion, duration: float, steps: int, *, aspect: float, across: int, strips: int, free: bool = False
) -> Wake:
    """Move a plate of chord 1 from rest in still water."""
    x, y = np.linspace(0, 1, across + 1), np.linspace(-aspect / 2, aspect / 2, strips + 1)
    # Rings a quarter of a panel behind their panels, flow tangential at three quarters; the last ring ends at the edge.
    middle = rings(x, y).mean(axis=1) + np.array([0.25 / across, 0, 0])
    bound = rings(np.minimum(x + 0.25 / across, 1), y)
    step, surface, size = duration / steps, aspect, area(bound)[:, 2]
    # Segments that feel a force: fronts of the rings, where two of them meet, and their sides.
    ends = np.concatenate([bound[:, [k, (k + 1) % 4]] for k in (3, 0, 2)])
    at, along = ends.mean(axis=1), ends[:, 1] - ends[:, 0]
    points = np.concatenate([middle, at])
    of_bound, edge = induced(points, bound), bound[-strips:, 1:3].reshape(-1, 3)
    edge = np.concatenate([edge[::2], edge[-1:]])
    lines, strength = np.empty((0, strips + 1, 3)), np.empty((0, strips))
    gamma, history = np.zeros(across * strips), [np.zeros(across * strips)] * 2
    record = []
    for time in step * np.arange(1, steps + 1):
        pose, speed = motion(time), velocity(motion, time, 1e-4 * step)
        lines[:1] = placed(edge, motion(time - 1.5 * step))
        lines = np.concatenate([placed(edge, motion(time - 0.25 * step))[np.newaxis], lines])
        wake = between(np.concatenate([edge[np.newaxis], placed(lines, pose, back=True)]))
        of_wake = induced(points, wake[:strips])
        # Flow past the plate, at first without that of the rings whose circulation is sought.
        past = np.einsum("nmi,m->ni", induced(points, wake[strips:]), strength.ravel())
        past -= np.stack([0 * points[:, 0] + speed[0], 0 * points[:, 0], speed[1] + speed[2] * points[:, 0]], axis=1)
        of_rings = of_bound.copy()
        of_rings[:, -strips:] += of_wake
        gamma = np.linalg.solve(of_rings[: len(middle), :, 2], -past[: len(middle), 2])
        past += np.einsum("nmi,m->ni", of_rings, gamma)
        net = gamma - np.append(np.zeros(strips), gamma[:-strips])
        pulls = np.cross(past[len(middle) :], along) * np.concatenate([net, gamma, gamma])[:, np.newaxis]
        rate = size * (3 * gamma - 4 * history[-1] + history[-2]) / (2 * step)
        force = pulls.sum(axis=0) - [0, 0, rate.sum()]
        moment = at[:, 0] @ pulls[:, 2] - bound[..., 0].mean(axis=1) @ rate
        history = [history[-1], gamma]
        strength = np.concatenate([gamma[np.newaxis, -strips:], strength])
        impulse = area(wake).T @ strength.ravel() + area(bound).T @ gamma
        at_rest = turned(impulse[::2], pose[2])
        forces = force[::2] / surface, pose[2:], at_rest / surface, [moment / surface]
        record.append(np.concatenate([[time], speed, *forces]))
        if free:
            nodes = placed(lines, pose, back=True).reshape(-1, 3)
            drift = induced(nodes, bound, CORE).transpose(0, 2, 1) @ gamma
            drift += induced(nodes, wake, CORE).transpose(0, 2, 1) @ strength.ravel()
            lines = lines + step * placed(drift, np.array([0, 0, pose[2]])).reshape(lines.shape)
    table = np.array(record)
    return Wake(table[:, 0], table[:, 1:4], table[:, 4:6], table[:, 6], table[:, 7:9], table[:, 9])


class Beat(NamedTuple):
    """Heaving and pitching of a plate of chord 1 that moves at speed 1."""

    reduced: float  # angular frequency times half of the chord over the speed
    heave: float  # amplitude over the chord
    pitch: float = 0.0  # amplitude [rad]
    lead: float = 0.0  # rad, of the pitch before the heave
    axis: float = 0.25  # chords behind the leading edge

    def motion(self, time: float) -> np.ndarray:
        """Return x, z and angle of the leading edge; positive angles raise the trailing edge."""
        phase = 2 * self.reduced * time
        angle = self.pitch * math.cos(phase + self.lead)
        height = self.heave * math.cos(phase) - self.axis * math.sin(angle)
        return np.array([-time + self.axis * (1 - math.cos(angle)), height, angle])

    @property
    def period(self) -> float:
        """Return the duration of a beat."""
        return math.pi / self.reduced


def deficiency(k: float) -> complex:
    """Return Theodorsen's C(k)."""
    return complex(hankel2(1, k) / (hankel2(1, k) + 1j * hankel2(0, k)))


def theory(beat: Beat) -> tuple[complex, float, float]:
    """Return Theodorsen's amplitude of the side force, Garrick's mean thrust and suction, on chord and rho U^2."""
    k, b, a = beat.reduced, 0.5, 2 * beat.axis - 1
    c = deficiency(k)
    omega = 1j * k / b
    # Down and nose up are positive there: height and angle with the other sign.
    h, alpha = -beat.heave, -beat.pitch * np.exp(1j * beat.lead)
    q = alpha + omega * h + b * (0.5 - a) * omega * alpha
    lift = math.pi * b**2 * (omega**2 * h + omega * alpha - b * a * omega**2 * alpha) + 2 * math.pi * b * c * q
    suction = math.pi * b / 4 * abs(2 * c * q - b * omega * alpha) ** 2
    return complex(lift), float(suction - (lift * np.conj(alpha)).real / 2), float(suction)


def last_beat(found: Wake, period: float) -> np.ndarray:
    """Return a mask of the steps of the last beat."""
    return found.time > found.time[-1] - period * (1 - 1e-9)


def beating(beat: Beat, beats: int, steps: int, **choices: Any) -> tuple[complex, float, float]:
    """Return the quantities of `theory` from a lattice's last beat."""
    found = flow(beat.motion, beats * beat.period, beats * steps, **choices)
    last = last_beat(found, beat.period)
    force = found.at_rest()[last]
    lift = 2 * np.mean(force[:, 1] * np.exp(-2j * beat.reduced * found.time[last]))
    return complex(lift), float(-force[:, 0].mean()), float(-found.force[last, 0].mean())


def fin_motion(swim: Any, chord: float) -> tuple[Motion, float]:
    """Return the motion of the end of a robot's last link in its settled beat, and the period.

    Lengths in chords, mean speed 1 along -x; the coefficients of Fourier continue the beat.
    """
    rows = swim.trajectory
    angle = rows["heading"].values + rows["joint_angle"].values.sum(axis=1)
    ends = rows["tail_x"].values + 1j * rows["tail_y"].values
    step = ends[-1] - ends[0]
    ends, angle = ends * abs(step) / -step, angle - np.angle(-step)
    lead = ends / chord - np.exp(1j * angle)
    period = abs(step) / chord
    count = len(lead) - 1
    drift = -period * np.arange(count) / count
    series = np.fft.rfft(np.stack([lead.real[:-1] - drift, lead.imag[:-1], angle[:-1]]), axis=1) / count
    order = np.arange(series.shape[1])

    def motion(time: float) -> np.ndarray:
        turn = np.exp(2j * math.pi * order * time / period)
        return (series * np.where(order > 0, 2, 1) @ turn).real - np.array([time, 0, 0])

    return motion, period


ASPECT, CHORD = 5.0, 0.032  # of HyperTuna's fin: span over chord; chord [m]
MASS = 0.897  # the fin's added mass over rho pi/4 c^2 b: edge_added_mass in robots/hypertuna.toml


def edge_terms(
    speed: np.ndarray, aspect: float, lift: float, suction: float, *, fade: bool = True, mass: float = MASS
) -> np.ndarray:
    """Return the force (n, 2) that the strip law adds to Kirchhoff's at an edge, along x and z of the plate.

    `speed` (n, 3) as in Wake; `mass` is the added mass over rho pi/4 c^2 b, `lift` and `suction` are edge_lift and
    edge_suction of a robot file (docs/model.md).
    """
    along, turn = np.abs(speed[:, 0]), speed[:, 2]
    middle = speed[:, 1] + turn / 2
    across = middle - np.sign(speed[:, 0]) * turn / 4  # at three quarters of the chord
    kept = along / np.hypot(along, across) if fade else np.ones(len(along))
    slope, carried = math.pi / 4 * aspect * lift, math.pi / 4 * mass
    attached = 2 * min(suction * (1 - lift / 2), 4 * carried / slope) * slope
    return np.stack(
        [-turn * carried * middle - attached / 2 * kept * middle**2, -slope * kept * along * across], axis=1
    )


def reaction(found: Wake) -> np.ndarray:
    """Return the force (n,) across the plate of an added mass of rho pi/4 c^2 b."""
    across = found.speed[:, 1] + found.speed[:, 2] / 2
    return -math.pi / 4 * np.gradient(across, found.time)


BEATS = (  # beats of a plate of infinite span that are compared with theory
    Beat(0.25, 0.05),
    Beat(0.5, 0.05),
    Beat(1.0, 0.05),
    Beat(0.5, 0.0, 0.05),
    Beat(0.5, 0.05, 0.03, math.pi / 2),
    Beat(1.0, 0.05, 0.05, math.pi / 2),
)
COARSE, FINE = (4, 8, 40), (6, 12, 60)  # panels along chord and span, steps a beat


def infinite_span(beat: Beat) -> dict[str, Any]:
    """Compare a plate of infinite span with theory: lattices of 8 and 16 panels, extrapolated."""
    coarse, fine = (np.array(beating(beat, 4, 32, aspect=1e4, across=n, strips=1)) for n in (8, 16))
    found, right = 2 * fine - coarse, np.array(theory(beat))
    ratio = found[0] / right[0]
    numbers = {
        "side_force_ratio": abs(ratio),
        "side_force_lead_deg": math.degrees(np.angle(ratio)),
        "thrust": found[1].real,
        "thrust_theory": right[1].real,
        "suction": found[2].real,
        "suction_theory": right[2].real,
    }
    return beat._asdict() | {key: float(f"{value:.5g}") for key, value in numbers.items()}


def fin(swim: Any, name: str, scale: float, size: tuple[int, int, int], *, free: bool = False) -> dict[str, Any]:
    """Compare the fin in a settled beat, its motion scaled, with the strip law's edge terms. Forces in N."""
    whole, period = fin_motion(swim, CHORD)

    def motion(time: float) -> np.ndarray:
        pose = whole(time)
        return scale * pose - (1 - scale) * np.array([time, 0, 0])

    across, strips, steps = size
    found = flow(motion, 3 * period, 3 * steps, aspect=ASPECT, across=across, strips=strips, free=free)
    last, unit = last_beat(found, period), swim.robot.water.density * swim.speed**2 * CHORD**2 * ASPECT
    lift = swim.robot.water.strip.edge_lift

    def thrust(force: np.ndarray) -> float:
        return float(-unit * turned(force, found.angle)[last, 0].mean())

    speed = found.speed[last]
    lifting = edge_terms(speed, ASPECT, lift, 0, fade=False)[:, 1] / lift
    columns = np.stack([lifting, reaction(found)[last]], axis=1)
    force = found.force[last, 1]
    fit, *_ = np.linalg.lstsq(columns, force, rcond=None)
    rest = force - columns @ fit
    law = edge_terms(speed, ASPECT, lift, 0)[:, 1] + MASS * columns[:, 1]
    numbers = {
        "reduced": math.pi / period,
        "incidence_deg": math.degrees(np.arctan2(np.abs(speed[:, 1] + speed[:, 2]), -speed[:, 0]).max()),
        "thrust_law": thrust(edge_terms(found.speed, ASPECT, lift, 0)),
        "thrust_law_suction": thrust(edge_terms(found.speed, ASPECT, lift, 1)),
        "thrust_normal": thrust(found.force * [0, 1]),
        "thrust": thrust(found.force),
        "normal_rms_law": unit * math.sqrt(np.mean(law**2)),
        "normal_rms": unit * math.sqrt(np.mean(force**2)),
        "edge_lift": fit[0],
        "added_mass": fit[1],
        "explained": 1 - rest @ rest / (force @ force),
    }
    how = {"gait": name, "scale": scale, "panels": [across, strips], "steps": steps, "free": free}
    return how | {key: float(f"{value:.5g}") for key, value in numbers.items()}


def main() -> None:
    """Compute the numbers for the tables, and store them."""
    import hypertuna as ht
    from hypertuna.description.provenance import provenance
    from hypertuna.paper.computed import SPEEDS
    from hypertuna.swimming.gait import named_gait

    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", type=Path)
    given = parser.parse_args()
    robot = ht.load("hypertuna").using(water="strip")
    swims = {name: ht.swim(robot, named_gait(robot, name)) for name in SPEEDS}
    one = "unoptimised-0.5"
    cases = [(one, scale, COARSE, False) for scale in (0.1, 0.5)] + [(name, 1.0, COARSE, False) for name in SPEEDS]
    cases += [(one, 1.0, COARSE, True), (one, 0.1, FINE, False), (one, 1.0, FINE, False)]
    record = provenance(robot) | {"command": shlex.join(["python", *sys.argv])}
    record["infinite_span"] = [infinite_span(beat) for beat in BEATS]
    record["fin"] = []
    for name, scale, size, free in cases:
        record["fin"].append(fin(swims[name], name, scale, size, free=free))
        print(json.dumps(record["fin"][-1]), flush=True)
        if given.o:
            given.o.write_text(json.dumps(record, indent=1) + "\n")


if __name__ == "__main__":
    main()
