# %% [markdown]
# # Sweep a grid of gaits, then optimize
#
# A grid combines every frequency with every amplitude, phase and bias. `sweep` swims them all on every processor.

# %%
import numpy as np

import hypertuna as ht

fish = ht.load("hypertuna")
gaits = ht.Gaits.grid_degrees(
    frequency=np.arange(1, 6.1, 0.5), amplitude=[(8, 15), (16, 25)], phase=[(0, lag) for lag in range(0, 101, 20)]
)
gaits

# %%
grid = ht.sweep(fish, gaits, progress=ht.progress_bar("gaits"))
ht.plot_sweep(grid)

# %% [markdown]
# The result is an xarray dataset: quantities are SI, and the axes have the unit of the grid, here degrees. Select by
# value: each axis is indexed by the last joint group whose angle differs.

# %%
near = grid.sel(frequency=3, phase=40, amplitude=25, method="nearest").isel(bias=0)
print(f"{near.speed:.3f} m/s for {near.cost_of_transport:.3f} J/(kg m)")

# %% [markdown]
# As a table, in degrees, with the unit in each name:

# %%
table = ht.to_pandas(grid)
table.nlargest(5, "speed_m_s")[["frequency_hz", "amplitude_II_deg", "phase_II_deg", "speed_m_s", "strouhal"]]

# %% [markdown]
# The fastest gait between the grid's points, by exact gradients:

# %%
best = ht.optimize(fish, maximize="speed", method="gradient")
best

# %% [markdown]
# Fast and cheap exclude each other. The front has the best compromises:

# %%
front = ht.pareto(fish, population=20, generations=20, progress=ht.progress_bar("rounds"))
front

# %%
front.plot()
