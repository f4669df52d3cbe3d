# %% [markdown]
# # From a CSV file of trials to fitted coefficients
#
# A row of the file is a steady swim: its gait, and its measured speed or cost of transport. The file here is
# synthetic: the model swam the gaits, and noise was added. The fit should find factors of 1.

# %%
import pandas as pd

import hypertuna as ht

file = "../tank/tank.csv"
pd.read_csv(file, comment="#").head()

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
fit.to_pandas()[["name", "value", "low", "high", "unit", "determined"]]

# %%
fit.plot()

# %% [markdown]
# `fit.robot` swims with the fitted coefficients. `hypertuna.description.writer.write_robot` writes it to a file.

# %%
before, after = (ht.swim(robot, "optimised-0.3") for robot in ("hypertuna", fit.robot))
print(f"{before.speed:.3f} m/s as described, {after.speed:.3f} m/s as fitted")
after
