"""Load a robot of your own, see what its speed depends on, and follow the gradient to a faster gait."""

from dataclasses import replace
from pathlib import Path

import numpy as np

import hypertuna as ht

fish = ht.load(Path(__file__).with_name("minnow.toml"))
gait = ht.named_gait(fish, "cruise")
swim = ht.swim(fish, gait)
print(f"{fish.name} cruises at {swim.speed:.3f} m/s for {swim.cost_of_transport:.2f} J/(kg m)")

gradient = ht.gradient(fish, gait)
derivative = dict(zip(gradient.names, gradient.speed, strict=True))
for g, joint in enumerate(fish.joints):
    more = np.radians(1) * derivative[f"gait.amplitude[{g}]"]
    print(f"one degree more of joint {joint.name}: {1000 * more:+.2f} mm/s")
drag = fish.water.strip.drag_normal[3]
print(f"a tenth more drag across the fin: {1000 * 0.1 * drag * derivative['water.strip.drag_normal[3]']:+.2f} mm/s")

for _ in range(8):  # uphill in the phases, 5 degrees a step
    gradient = ht.gradient(fish, gait)
    uphill = np.array([gradient.speed[gradient.names.index(f"gait.phase[{g}]")] for g in range(3)])
    gait = replace(gait, phase=tuple(gait.phase + np.radians(5) * uphill / np.linalg.norm(uphill)))
faster = ht.swim(fish, gait)
lags = np.degrees(np.subtract(gait.phase, gait.phase[0]))
print(f"lags of {', '.join(f'{lag:.0f}' for lag in lags)} deg: {faster.speed:.3f} m/s")
