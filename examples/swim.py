"""Swim one gait of HyperTuna, print what it costs and draw it to swim.svg."""

import hypertuna as ht
from hypertuna.figures import save
from hypertuna.swimming.plots import plot_swim

fish = ht.load("hypertuna")
gait = ht.Gait.from_degrees(frequency=6, amplitude=(16, 25), phase=(0, 40))
swim = ht.swim(fish, gait)

print(swim.status_text)
print(f"speed {swim.speed:.3f} m/s, {swim.speed_bl:.2f} BL/s")
print(f"mechanical power {swim.mechanical_power:.2f} W, cost of transport {swim.cost_of_transport:.2f} J/(kg m)")
print(f"Strouhal number {swim.strouhal:.2f}, stride length {swim.stride_length:.2f} BL")
save(plot_swim(swim), "swim.svg")
