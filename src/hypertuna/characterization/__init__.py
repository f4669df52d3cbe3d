"""Characterization: unknowns of an actuator from its test bench.

data: rows of a bench. unknowns: geometry and material parameters, their bounds and logarithms.
problem, fit: residuals with the bounds as a prior, and the fit by the estimator of `hypertuna.identification`.
sampling, combinations: randomized fits, and the products of powers that the bench determines.
experiment_design: the expected information gain of another measurement. plots: the figure of a fit.
"""
