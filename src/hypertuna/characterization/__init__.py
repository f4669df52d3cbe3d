"""Characterization: unknowns of an actuator from its test bench.

data: rows of a bench. unknowns: geometry and material parameters, their bounds and logarithms.
problem, fit: residuals with the bounds as a prior, and the fit by the estimator of `hypertuna.identification`.
sampling, combinations: randomized fits, and the products of powers that the bench determines.
experiment_design: the expected information gain of another measurement. plots: the figure of a fit.
room: whether muscles and pipes fit in a joint. designs, population: designs that meet a bench, solved for and drawn.
family: a sample of all of them, what they leave open, and what to measure next. plots_family: its figure.
checked: the chosen design by finite elements.
cards: what is shown.
"""
