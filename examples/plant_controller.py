"""A controller of your own on the plant of HyperTuna, in FMPy: once a beat, bend sensors correct the servos.

Needs `make fmu` and the package fmpy. Run: python examples/plant_controller.py
"""

import math
import tempfile
from pathlib import Path

import fmpy
import numpy as np

import hypertuna as ht

TICK, NEUTRAL, PER_RAD = 0.01, 1.5e-3, 6.37e-4  # s; pulse [s] of a servo at neutral, and by its angle [rad]
FREQUENCY, AMPLITUDE, LAG = 1.0, np.radians([8.0, 14.0]), np.array([0.0, 0.7])  # Hz, rad of the bends


def swim(file: Path, duration: float) -> np.ndarray:
    """Swim for a while [s]; return time, x, y and both bends in each tick."""
    folder = fmpy.extract(str(file))
    about = fmpy.read_model_description(folder)
    at = {variable.name: variable.valueReference for variable in about.modelVariables}
    fish = fmpy.instantiate_fmu(folder, about)
    fish.setInteger([at["seed"]], [1])
    fish.setupExperiment(startTime=0.0)
    fish.enterInitializationMode()
    fish.exitInitializationMode()
    shown = [at[name] for name in ("time", "x", "y", "angle_I", "angle_II")]
    sensors = [at["bend_read_I"], at["bend_read_II"]]
    servos = [at[f"pulse_command_{joint}_{side}"] for joint in ("I", "II") for side in ("left", "right")]
    rows, readings, beat = [], [], round(1 / FREQUENCY / TICK)
    drive = np.array([0.1, 0.1])  # amplitudes of the servos [rad]
    for k in range(round(duration / TICK)):
        rows.append(fish.getReal(shown))
        readings.append(fish.getReal(sensors))
        if k and k % beat == 0:
            seen = np.ptp(readings[-beat:], axis=0) / 2
            drive = drive * np.clip(AMPLITUDE / seen, 0.7, 1.3)
        angles = drive * np.sin(2 * math.pi * FREQUENCY * k * TICK - LAG)
        sides = np.stack([angles, -angles], axis=1)  # one side pushes oil, the other draws it
        fish.setReal(servos, (NEUTRAL + PER_RAD * sides).ravel().tolist())
        fish.doStep(k * TICK, TICK)
    fish.terminate()
    fish.freeInstance()
    return np.array(rows)


with tempfile.TemporaryDirectory() as made:
    plant = Path(made) / "plant.fmu"
    plant.write_bytes(ht.fmu("hypertuna", kind="plant"))
    motion = swim(plant, duration=20)
bends = np.ptp(motion[-100:, 3:], axis=0) / 2
distance = float(np.hypot(*motion[-1, 1:3]))
print(f"swam {distance:.2f} m in 20 s; the last beat bends the joints by {np.degrees(bends).round(1).tolist()} deg")
