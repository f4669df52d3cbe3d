"""Random sensor faults in the twin, for README.md. Run: python validation/faults/runs.py [RUNS [FIRST_SEED]]."""

from __future__ import annotations

import sys
from typing import Any, NamedTuple

import numpy as np

import hypertuna as ht
from hypertuna.control.sensors import channels
from hypertuna.simulation.run import TwinRun

ROBOT = ht.load("hypertuna")
THREADS = 2
SECONDS = 10.0  # duration of a run [s]; the fault starts between 1 and 6 s
CONTROL = ROBOT.controller
HARD = 1.05 * (CONTROL.pressure_hard if CONTROL and CONTROL.pressure_hard else np.inf)  # Pa, 5 % above the hard limit
# Condition that must report a fault, by the faulty sensor
CONDITIONS = {"bend": "bend_fault", "pressure": "pressure_fault", "current": "current_fault", "imu": "imu_fault"} | {
    "battery": "battery_fault"
}
PLAIN = ("stuck", "open", "spike", "nan")  # kinds that every channel must report; validation/control has gradual ones
SWING_MIN = 0.5  # minimum swing of each joint, relative to the healthy run


class Result(NamedTuple):
    """What is judged of a run."""

    peak: float  # maximum pressure of any cylinder or drive unit [Pa]
    finite: bool
    pulses: bool  # whether all servo pulses keep within range and rate limit
    swing: np.ndarray  # each joint's amplitude in the last beats, half of peak to peak [rad]
    conditions: frozenset[str]
    limits: tuple[str, ...]


def measure(run: TwinRun) -> Result:
    """Return what is judged of a run."""
    control = run.robot.controller
    assert control is not None
    pulse, step = run.data["pulse"], control.slew * run.tick * control.pulse_per_rad
    inside = (control.pulse_min <= pulse).all() and (pulse <= control.pulse_max).all()
    slewed = abs(np.diff(pulse, axis=0, prepend=control.pulse_center)).max() <= step * (1 + 1e-9)
    numbers = all(np.isfinite(values).all() for name, values in run.data.items() if name not in READ)
    names = [name for bit, (name, _, _) in enumerate(ht._core.condition_table()) if run.flags >> bit & 1]
    finite = bool(numbers) and run.status == "completed"
    return Result(run.pressure_peak, finite, bool(inside and slewed), run.swing, frozenset(names), run.limits)


READ = ("angle_measured", "pressure_measured", "current")  # a faulty sensor may read NaN


def sample(seed: int) -> tuple[dict[str, Any], str]:
    """Sample a run and its fault: channel, kind, time, frequency, amplitudes, lag and seed of the noise."""
    random = np.random.default_rng(seed)
    amplitude = (random.uniform(4, 16), random.uniform(6, 25))
    gait = ht.Gait.from_degrees(frequency=random.uniform(1, 6), amplitude=amplitude, phase=(0, random.uniform(0, 60)))
    names = [name for name in channels(ROBOT, pilot=False) if name.split("-")[0] in CONDITIONS]
    fault = f"{random.choice(names)}:{random.choice(PLAIN)}@{random.uniform(1, 6):.2f}"
    return {"robot": ROBOT, "gait": gait, "duration": SECONDS, "seed": seed}, fault


def both(seeds: range, threads: int = THREADS) -> list[tuple[str, dict[str, Any], Result, Result]]:
    """Run every sample healthy and with its fault."""
    samples = [sample(seed) for seed in seeds]
    healthy = ht.twins([run for run, _ in samples], measure=measure, threads=threads)
    faulty = ht.twins([run | {"faults": fault} for run, fault in samples], measure=measure, threads=threads)
    return [(fault, run, a, b) for (run, fault), a, b in zip(samples, healthy, faulty, strict=True)]


def condition(fault: str) -> str:
    """Return the condition that must be reported."""
    return CONDITIONS[fault.split(":")[0].split("-")[0]]


def main() -> None:
    """Run, and print failures and the summary."""
    count, first = (int(a) for a in (*sys.argv[1:], "500", "0")[:2]) if len(sys.argv) > 1 else (500, 0)
    rows = both(range(first, first + count))
    for k, (fault, run, healthy, faulty) in enumerate(rows):
        gait, part = run["gait"], faulty.swing / healthy.swing
        wrong = [
            *(["pressure"] if faulty.peak > HARD or healthy.peak > HARD else []),
            *(["not finite"] if not faulty.finite else []),
            *(["pulses"] if not faulty.pulses else []),
            *(["not reported"] if condition(fault) not in faulty.conditions else []),
            *(["false fault"] if any(c.endswith(("_fault", "_stop")) for c in healthy.conditions) else []),
            *(["stops"] if "hard_stop" in faulty.conditions else []),
            *(["weak"] if part.min() < SWING_MIN else []),
        ]
        if wrong:
            gist = f"{gait.frequency:.2f} Hz {np.degrees(gait.amplitude).round(1)} {fault}"
            peaks = f"{healthy.peak / 1e3:.0f} {faulty.peak / 1e3:.0f} kPa"
            print(first + k, gist, peaks, part.round(2), *wrong, sorted(faulty.conditions), flush=True)
    peak = np.array([(h.peak, f.peak) for _, _, h, f in rows]) / 1e3
    part = np.array([f.swing / h.swing for _, _, h, f in rows]).min(axis=1)
    print(
        f"{count} runs; maximum pressure {peak[:, 0].max():.0f} kPa healthy, {peak[:, 1].max():.0f} kPa with the fault"
    )
    print(f"reported: {np.mean([condition(fault) in f.conditions for fault, _, _, f in rows]):.1%}")
    print(
        f"false faults in healthy runs: {sum(any(c.endswith('_fault') for c in h.conditions) for _, _, h, _ in rows)}"
    )
    print(f"hard stops: {sum('hard_stop' in f.conditions for _, _, _, f in rows)}")
    print(
        "swing relative to the healthy run, minimum, 1 %, 5 %, median:",
        np.quantile(part, [0, 0.01, 0.05, 0.5]).round(3),
    )


if __name__ == "__main__":
    main()
