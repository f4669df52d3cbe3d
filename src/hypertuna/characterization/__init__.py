"""Characterization: unknowns of an actuator, identified from its test bench.

data: rows of a bench. unknowns: geometry and material parameters, their bounds and logarithms.
problem, fit: residuals with the bounds as a prior, and the fit by the estimator of `hypertuna.identification`.
sampling, combinations: randomized fits, and the products of powers that the bench determines.
experiment_design: the expected information gain of another measurement. plots: figures.
designs, population: the designs that meet a bench and fit in the sections; sampling of them.
family: a sample of these designs, quantities that they leave open, and what to measure next.
checked: the chosen design of a family by finite elements. spring: the spring of a hinge from weights and angles.
cards: results as text.
"""
