"""Reinforcement learning on the twin (extra `rl`).

spans (actions and their ranges), swimmers, tasks, environments, sb3 (for Stable-Baselines3), policy (a network, and the
pilot to compare it with), header (a policy for the firmware).

`import hypertuna.learning` registers hypertuna/Swim-v0, Turn-v0, Goto-v0 and Station-v0 with Gymnasium.
"""

from hypertuna.io.extras import need

need("rl", "gymnasium", by="hypertuna.learning")

from hypertuna.learning.environments import register as _register  # noqa: E402

_register()
