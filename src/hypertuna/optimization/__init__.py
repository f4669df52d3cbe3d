"""Design space, objectives, optimizers, Pareto front, tank in the loop."""
