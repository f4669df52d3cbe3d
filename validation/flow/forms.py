"""Forms of the force on a fin: on a plate that heaves and pitches in a stream, beside lattices and theory.

    python validation/flow/forms.py [-o FILE]

A plate of chord, density and speed 1 moves along -x. Its normal speed at x behind the leading edge is v(x) = v_0 + x w
with w = d(angle)/dt. Every form has Kirchhoff's reaction of the plate's added mass M at mid-chord, in the plate's axes

    f_t = w M v(1/2),   f_n = -M dv(1/2)/dt,   N = -I dw/dt - v_t M v(1/2) about mid-chord,

and adds what follows (V = max(0, -v_t), L = lift slope / 2, H = V/|v|; all forces are on the area):

    before  f_n = -L H V v(1) at the trailing edge: the law until version 0.3
    S       the same, and f_t = -w M v(1/2)                   (H on what exceeds the smaller of M/2 and L)
    P       f_n = -L V v(3/4) at d behind mid-chord, f_t = -w M v(1/2), d = (1/2 - sqrt(M/L))^2
    quarter as P, with d = M/L - 1/4, so that the steady lift acts at the quarter chord: the law of a fin of its own

The law also has H on the lift, and takes (1 - H) of Munk's moment back. H is 1 in small motions, and V is 0 at rest.

The lattice gives the response to heave and to pitch about the leading edge, extrapolated from two lattices. A plate
without thickness feels pressure only across itself: its thrust without suction is that of the normal force alone.
main() computes the responses (a quarter of an hour), table.py the tables.
"""

import argparse
import json
import math
import runpy
import shlex
import sys
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

HERE = Path(__file__).parent
WAKE = runpy.run_path(str(HERE / "wake.py"))
FIN, deficiency = WAKE["FIN"], WAKE["deficiency"]
STREAM = (0.2, 0.6, 1.2)  # reduced frequencies of beats in a stream
ASPECTS = (2.43, 5.0)  # aspect ratios of plates
# By whether the span is finite: panels along chord and span, steps a beat
SIZES = {True: ((4, 8, 32), (6, 12, 48)), False: ((8, 1, 32), (16, 1, 64))}
PITCHES, INCIDENCES = (15.0, 30.0), (10.0, 20.0, 40.0, 60.0)  # deg, in still water and in steady flow
FORMS = ("before", "S", "P", "quarter")  # described in README.md
AMPLITUDE = 0.1  # of heave, over the chord, and of pitch [rad]
MOTIONS = ("pitch about the leading edge", "pitch about a hinge a chord ahead", "heave", "heave, half feathered")


def motion(name: str, k: float) -> tuple[complex, complex]:
    """Return the amplitudes of heave and pitch; half feathered, the plate turns by half of its path's angle."""
    feathered = 0, -1j * k * AMPLITUDE
    pitches = dict(zip(MOTIONS, (AMPLITUDE, AMPLITUDE, *feathered), strict=True))
    return (0 if name == MOTIONS[0] else AMPLITUDE), pitches[name]


class Plate(NamedTuple):
    """Coefficients of a plate of chord 1, on its area."""

    mass: float  # added mass
    lift: float  # half of the lift slope
    inertia: float  # added moment of inertia about mid-chord; it changes no mean value

    @property
    def lever(self) -> float:
        """Return how far behind mid-chord the lift of form P acts."""
        return float((0.5 - math.sqrt(self.mass / self.lift)) ** 2)


class Response(NamedTuple):
    """Amplitudes of normal force and moment about the leading edge, and a form's mean axial force."""

    force: complex
    moment: complex
    axial: float = 0.0


STRIP = Plate(math.pi / 4, math.pi, math.pi / 128)  # of infinite span


def plate(aspect: float) -> Plate:
    """Return the coefficients that fin.py computes."""
    found = FIN["plate"](aspect)
    mass = math.pi / 4 * found.added_mass
    return Plate(mass, found.lift_slope / 2, mass / 12 * found.added_inertia)


def response(form: str, part: Plate, k: float, heave: complex, pitch: complex) -> Response:
    """Return the response of a form to a small motion exp(2 i k t) at speed 1; theory's C(k) for "Theodorsen"."""
    rate = 2j * k
    front, turn = rate * heave + pitch, rate * pitch

    def speed(x: float) -> complex:
        return front + x * turn

    middle, mass = speed(0.5), part.mass
    at, lever = {"P": (0.75, part.lever), "quarter": (0.75, mass / part.lift - 0.25)}.get(form, (1.0, 0.5))
    lift, munk = -part.lift * speed(at), mass * middle
    if form == "Theodorsen":  # circulation acts at the quarter chord
        lift, lever, munk = -part.lift * deficiency(k) * speed(0.75), -0.25, mass * (middle - speed(0.75))
    force = -mass * rate * middle + lift
    moment = -part.inertia * rate * turn + munk + lever * lift + force / 2
    return Response(force, moment, mass * float((turn * np.conj(middle)).real) / 2 if form == "before" else 0.0)


def thrust_and_power(found: Response, k: float, heave: complex, pitch: complex) -> tuple[float, float]:
    """Return the mean thrust without suction, and the mean power of heave and pitch at the leading edge."""
    rates = -2j * k * np.conj(heave), -2j * k * np.conj(pitch)
    thrust = (found.force * np.conj(pitch)).real / 2 - found.axial
    return float(thrust), float(-(found.force * rates[0] + found.moment * rates[1]).real / 2)


def lattice(aspect: float, k: float, pitch: bool) -> Response:
    """Return the response of a lattice to a unit of heave, or of pitch about the leading edge."""
    small, rows = 0.01, []
    beat = WAKE["Beat"](k, 0.0, small, 0.0, 0.0) if pitch else WAKE["Beat"](k, small, 0.0, 0.0, 0.0)
    sizes = SIZES[aspect < 1e3]
    for across, strips, steps in sizes:
        found = WAKE["flow"](beat.motion, 3 * beat.period, 3 * steps, aspect=aspect, across=across, strips=strips)
        last = WAKE["last_beat"](found, beat.period)
        turn = 2 * np.exp(-2j * k * found.time[last]) / small
        rows.append([np.mean(found.force[last, 1] * turn), np.mean(found.moment[last] * turn)])
    (coarse, fine), (n, m) = np.array(rows), (size[0] for size in sizes)
    return Response(*(fine + (fine - coarse) * n / (m - n)).tolist())


def still(aspect: float, degrees: float, mass: float) -> list[list[float]]:
    """Return the thrust of a plate that pitches about its leading edge in still water: normal force's, and total.

    Each by two lattices with a free wake, second beat, over Lighthill's M/2 times the mean square of v(1).
    """
    amplitude, rows = math.radians(degrees), []

    def motion(time: float) -> np.ndarray:
        return np.array([0.0, 0.0, amplitude * math.sin(2 * math.pi * time)])

    for across, strips, steps in SIZES[True]:
        found = WAKE["flow"](motion, 2.0, 2 * steps, aspect=aspect, across=across, strips=strips, free=True)
        last = WAKE["last_beat"](found, 1.0)
        lighthill = mass * np.mean(found.speed[last, 2] ** 2) / 2
        forces = found.force * [0, 1], found.force
        rows.append([-WAKE["turned"](force, found.angle)[last, 0].mean() / lighthill for force in forces])
    return np.round(np.transpose(rows), 4).tolist()


def steady(aspect: float, degrees: float) -> dict[str, float]:
    """Return C_N of attached flow at an incidence after 20 chords, and where it acts behind the leading edge."""
    angle, rows = math.radians(degrees), []
    for across, strips, _ in SIZES[True]:
        choices = {"aspect": aspect, "across": across, "strips": strips}
        found = WAKE["flow"](lambda time: np.array([-time, 0.0, -angle]), 20.0, 20, **choices)
        rows.append([2 * found.force[-1, 1], found.moment[-1] / found.force[-1, 1]])
    normal, center = 3 * np.array(rows[1]) - 2 * np.array(rows[0])
    return {"aspect": aspect, "incidence_deg": degrees, "normal": round(normal, 4), "center": round(center, 4)}


def complexes(found: Response) -> list[float]:
    """Return force and moment as real and imaginary parts."""
    return [float(f"{x:.5g}") for z in found[:2] for x in (z.real, z.imag)]


def main() -> None:
    """Compute the responses of lattices, and store them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", type=Path)
    given = parser.parse_args()
    record: dict[str, Any] = {"command": shlex.join(["python", *sys.argv]), "plates": [], "stream": []}
    record |= {"still": [], "steady": [steady(aspect, degrees) for aspect in ASPECTS for degrees in INCIDENCES]}
    for aspect in (math.inf, *ASPECTS):
        finite = min(aspect, 1e4)
        part = STRIP if aspect == math.inf else plate(aspect)
        record["plates"].append({"aspect": finite, **part._asdict()})
        for k in STREAM:
            sides = [complexes(lattice(finite, k, pitch)) for pitch in (False, True)]
            record["stream"].append({"aspect": finite, "k": k, "heave": sides[0], "pitch": sides[1]})
        for degrees in PITCHES if aspect < math.inf else ():
            normal, thrust = still(aspect, degrees, part.mass)
            record["still"].append({"aspect": aspect, "pitch_deg": degrees, "normal": normal, "thrust": thrust})
    text = json.dumps(record, indent=1) + "\n"
    print(text)
    if given.o:
        given.o.write_text(text)


if __name__ == "__main__":
    main()
