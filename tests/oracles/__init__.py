"""Independent oracles: the same physics as the core, derived and written a second time, slowly and plainly.

Nothing here imports hypertuna. Reading order: ``planar`` (NumPy, any chain, both water laws), ``beats`` (a gait swum
with it), ``mujoco_chain`` (lumped law), ``lagrangian`` (sympy, strip law's added mass), ``kirchhoff`` (closed forms of
a single rigid body), ``cases`` (random chains to compare on).
"""
