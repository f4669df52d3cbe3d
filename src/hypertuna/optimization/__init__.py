"""Optimization of gaits, and of robots with them.

In reading order: `design_space` (free values and bounds), `constraints` (limits), `objective`, `problem` (objectives
and limits evaluated in batches, also over robots sampled from a fit), `optimizers` (ask, tell, stop, result;
hypervolume), `sqp` (searches by gradients), `optimize` and `optimum`, `pareto` and `polish` (fronts), `state` (the file
of a search whose runs a tank makes), `experiment` (the tank in the loop), `plots`, `cards` (results as text).
"""
