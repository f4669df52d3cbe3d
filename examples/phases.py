"""Sweep frequency and phase at the three amplitudes of the paper's Fig. 10, and draw them to phases.svg."""

import numpy as np

import hypertuna as ht
from hypertuna.figures import save
from hypertuna.swimming.plots import plot_sweep

fish = ht.load("hypertuna").using(joints="ideal")
amplitudes = {"small": (8, 15), "medium": (12, 20), "large": (16, 25)}
phases = np.arange(0, 101, 20)
gaits = ht.Gaits.grid(
    frequency=[1, 2, 3, 4, 5, 6],
    amplitude=[np.radians(a) for a in amplitudes.values()],
    phase=[(0.0, p) for p in np.radians(phases)],
)
found = ht.sweep(fish, gaits)

print(f"{len(gaits)} gaits, {int(found.settled.sum())} settled")
best = found.speed.isel(bias=0).argmax("phase")  # by frequency and amplitude
for k, name in enumerate(amplitudes):
    print(f"{name} amplitude: fastest at a phase difference of {phases[best[-1, k]]} deg")
save(plot_sweep(found), "phases.svg")
