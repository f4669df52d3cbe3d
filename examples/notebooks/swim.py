# %% [markdown]
# # Your own robot swims
#
# Begin with three numbers: the number of links, the length and the mass. Every other value is an estimate that names
# its rule; replace the estimates as you measure.

# %%
# !hypertuna robot new my_fish.toml --links 3 --length 0.3 --mass 0.85

# %%
import hypertuna as ht

fish = ht.load("my_fish.toml")
fish

# %% [markdown]
# The file names a gait, `cruise`. `swim` finds its settled beat: the motion that repeats itself.

# %%
swim = ht.swim(fish, "cruise")
swim

# %% [markdown]
# Print a result for its text. `.plot()` draws it, and `.to_pandas()` returns the motion, with the unit of each
# column in its name.

# %%
print(swim)

# %%
swim.plot()

# %%
swim.to_pandas()[["time_s", "x_m", "forward_speed_m_s", "mechanical_power_w"]].head()

# %% [markdown]
# What matters most? The gradient is exact, and sorted by influence: the change of the speed for 1 % more of a
# parameter, or for 1 degree more of an angle. Measure the values at the top first.

# %%
ht.gradient(fish, "cruise")

# %% [markdown]
# Another gait: angles in degrees, one per joint group. The phase is the lag behind the first group.

# %%
faster = ht.Gait.from_degrees(frequency=2.5, amplitude=(15, 25), phase=(0, 50))
ht.swim(fish, faster)

# %% [markdown]
# A mistake is one sentence that names the argument, the rule and a fix.

# %%
try:
    ht.swim(fish, "cruize")
except ht.InputError as error:
    print(error)
