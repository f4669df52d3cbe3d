"""Make trials as a tank would, by HyperTuna's model, with noise drawn by a seed.

`python make.py` writes beside itself tank.csv, 24 steady runs, and angles.csv and poses.csv, three tracked swims, which
tank.toml names; tow.csv, thrust.csv, power.csv, glide.csv and yaw.csv, which forces.toml names; and turn.csv, which
turns.toml names.
"""

import sys
from pathlib import Path

import numpy as np

import hypertuna as ht
from hypertuna import _core
from hypertuna.identification.experiment import experiment
from hypertuna.identification.prediction import predict
from hypertuna.swimming.model import core_model
from hypertuna.trials.kind_decay import Glides, YawDecays
from hypertuna.trials.numbers import HeldThrust, PowerRun, Tow, TurnRun
from hypertuna.trials.replay import head_center

SEED = 1
NOISE = 0.01  # relative, of speed and cost of transport of a single swim
REPEATS = 3
ANGLE_NOISE = np.radians(0.1)
POSE_NOISE = np.array([0.001, 0.001, np.radians(0.3)])  # m, m, rad of a single frame
DRIFT = np.array([0.003, 0.003, np.radians(1.0)])  # per s, of a run: waves, hose, start

fish = ht.load("hypertuna")
random = np.random.default_rng(SEED)
folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent


def write(name: str, head: list[str], rows: list[list[str]]) -> None:
    """Write a CSV file below a line that says what it is."""
    lines = ["# synthetic: made by make.py", ",".join(head), *(",".join(row) for row in rows)]
    (folder / name).write_text("\n".join(lines) + "\n", encoding="utf-8")


# Steady runs: the mean of three swims, with the standard deviation of one.
rows = []
for amplitude in ((8, 15), (16, 25)):
    for phase in (0, 40):
        for frequency in range(1, 7):
            swim = ht.swim(fish, ht.Gait.from_degrees(frequency=frequency, amplitude=amplitude, phase=(0, phase)))
            cells = [f"{value}" for value in (frequency, *amplitude, phase)]
            for value in (swim.speed, swim.cost_of_transport):
                repeats = value * (1 + NOISE * random.standard_normal(REPEATS))
                cells += [f"{repeats.mean():.5f}", f"{NOISE * value:.5f}"]
            rows.append([*cells, f"{REPEATS}"])
angles_of_gait = ["amplitude_I_deg", "amplitude_II_deg", "phase_II_deg"]
speed, cost = ["speed_m_s", "speed_sd_m_s"], ["cost_of_transport_j_per_kg_m", "cost_of_transport_sd_j_per_kg_m"]
write("tank.csv", ["frequency_hz", *angles_of_gait, *speed, *cost, "repeats"], rows)

# A swim from rest: joint angles at 100 Hz, growing over the first half second, and what a camera saw of three repeats.
time = np.arange(201) / 100
growth = np.clip(time / 0.5, 0, 1) ** 3
wave = np.sin(2 * np.pi * 2 * time[:, np.newaxis] - np.radians([0, 40]))
made = growth[:, np.newaxis] * np.radians([16, 25]) * wave
series = ht.JointSeries(time, made + ANGLE_NOISE * random.standard_normal(made.shape))
angles = np.degrees(np.column_stack([series.angle, made]))
rows = [[f"{t:.2f}", *(f"{a:.3f}" for a in row)] for t, row in zip(time, angles, strict=True)]
write("angles.csv", ["time_s", "joint_I", "joint_II", "target_I", "target_II"], rows)

replayed = ht.replay(fish, series, start=ht.Pose.from_head_center(fish, 0.5, 1.0, np.radians(10)))
frames = np.arange(60) / 30
track = np.column_stack([np.interp(frames, replayed.time, axis) for axis in head_center(fish, replayed).T])
rows = []
for run in "abc":
    poses = track + DRIFT * random.standard_normal(3) * frames[:, np.newaxis]
    poses += POSE_NOISE * random.standard_normal(poses.shape)
    for t, (x, y, yaw) in zip(frames, poses, strict=True):
        rows.append([run, f"{t:.4f}", f"{1000 * x:.2f}", f"{1000 * y:.2f}", f"{np.degrees(yaw):.3f}"])
write("poses.csv", ["run", "time_s", "x_mm", "y_mm", "yaw_deg"], rows)

# Forces on a fish that is towed, and on one that is held while it beats; power of beats.
FORCE_NOISE = 0.02  # relative
gaits = [ht.Gait.from_degrees(frequency=f, amplitude=(8, 15), phase=(0, 40)) for f in (1, 2, 3)]
tows = [Tow(f"{u}", 1.0, u=u) for u in (0.2, 0.3, 0.4, 0.5)]
holds = [HeldThrust(f"{gait.frequency}", 1.0, gait=gait) for gait in gaits]
powers = [PowerRun(f"{gait.frequency}", 1.0, gait=gait) for gait in gaits]
for name, blank, head in (
    ("tow.csv", tows, ["u_m_s", "drag_n", "drag_sd_n"]),
    ("thrust.csv", holds, ["frequency_hz", *angles_of_gait, "thrust_n", "thrust_sd_n"]),
    ("power.csv", powers, ["frequency_hz", *angles_of_gait, "power_w", "power_sd_w"]),
):
    exact = predict(experiment(fish, ht.Trials(tuple(blank))), [], gradient_steps=None).computed
    noisy = exact * (1 + FORCE_NOISE * random.standard_normal(len(exact)))
    own = [[f"{one.u}"] if one.gait is None else [f"{one.gait.frequency:g}", "8", "15", "40"] for one in blank]
    rows = [[*cells, f"{v:.4f}", f"{FORCE_NOISE * abs(v):.4f}"] for cells, v in zip(own, noisy, strict=True)]
    write(name, head, rows)

# A straight body that coasts, and one that was turned on the spot and let go.
time, steps = np.arange(31) / 10, 3000
still = np.zeros((2 * steps + 1, len(fish.links.name), 3))
for name, kind, first, noise, unit in (
    ("glide.csv", Glides(), 0.4, 0.004, "speed_m_s"),
    ("yaw.csv", YawDecays(), np.radians(90), np.radians(1), "yaw_rate_deg_s"),
):
    start = first * kind.begin(fish)
    made = _core.advance(core_model(fish), still, step=time[-1] / steps, twist=start, pose=np.zeros(3))["twist"]
    values = np.abs(made[:: steps // 30, kind.axis]) + noise * random.standard_normal(len(time))
    factor = kind.quantities[0].per_si
    rows = [[f"{t:.1f}", f"{factor * v:.4f}", f"{factor * noise:.4f}"] for t, v in zip(time, values, strict=True)]
    write(name, ["time_s", unit, unit.replace("_m_s", "_sd_m_s").replace("_deg_s", "_sd_deg_s")], rows)

# Gaits that bend to one side and turn.
turns = [TurnRun(f"{b}", 1.0, gait=ht.Gait.from_degrees(frequency=2, amplitude=(8, 15), phase=(0, 40), bias=(b, b)))
         for b in (4, 8, -8)]  # fmt: skip
exact = predict(experiment(fish, ht.Trials(tuple(turns))), [], gradient_steps=None).computed
noisy = np.degrees(exact * (1 + FORCE_NOISE * random.standard_normal(len(exact))))
rows = [["2", "8", "15", "40", one.name, one.name, f"{v:.3f}", f"{FORCE_NOISE * abs(v):.3f}"]
        for one, v in zip(turns, noisy, strict=True)]  # fmt: skip
biases = ["bias_I_deg", "bias_II_deg"]
write("turn.csv", ["frequency_hz", *angles_of_gait, *biases, "turn_rate_deg_s", "turn_rate_sd_deg_s"], rows)
