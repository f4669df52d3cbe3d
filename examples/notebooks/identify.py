# %% [markdown]
# # From a CSV file of trials to fitted coefficients
#
# A row of the file is a steady swim: its gait, and its measured speed or cost of transport. This notebook makes a
# synthetic file: the model swims the gaits, and noise is added. The fit should find factors of 1. To fit your own
# trials, write a file with these columns, and name it in place of this cell.

# %%
import numpy as np
import pandas as pd

import hypertuna as ht

file, noise, repeats, random = "tank.csv", 0.01, 3, np.random.default_rng(1)
rows = []
for amplitude in ((8, 15), (16, 25)):
    for phase in (0, 40):
        for frequency in range(1, 7):
            gait = ht.Gait.from_degrees(frequency=frequency, amplitude=amplitude, phase=(0, phase))
            swim = ht.swim("hypertuna", gait)
            row = [frequency, *amplitude, phase]
            for value in (swim.speed, swim.cost_of_transport):
                row += [value * (1 + noise * random.standard_normal(repeats)).mean(), noise * value]
            rows.append([*row, repeats])
angles = ["amplitude_I_deg", "amplitude_II_deg", "phase_II_deg"]
speed, cost = ["speed_m_s", "speed_sd_m_s"], ["cost_of_transport_j_per_kg_m", "cost_of_transport_sd_j_per_kg_m"]
table = pd.DataFrame(rows, columns=["frequency_hz", *angles, *speed, *cost, "repeats"]).round(5)
table.to_csv(file, index=False)
table.head()

# %%
trials = ht.read_trials(file, "hypertuna")
trials

# %% [markdown]
# By default, `identify` fits one factor each on the drag along the body, the drag across it and the added
# mass. It keeps a fifth of the runs to check the fit with.

# %%
fit = ht.identify("hypertuna", trials)
fit

# %% [markdown]
# The intervals hold 95 %. `to_pandas` has them for your own tables.

# %%
fit.to_pandas()[["name", "value", "low", "high", "unit", "constrained"]]

# %%
fit.plot()

# %% [markdown]
# `fit.robot` swims with the fitted coefficients. `hypertuna.description.writer.write_robot` writes it to a file.

# %%
before, after = (ht.swim(robot, "optimised-0.3") for robot in ("hypertuna", fit.robot))
print(f"{before.speed:.3f} m/s as described, {after.speed:.3f} m/s as fitted")
after
