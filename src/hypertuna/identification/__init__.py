"""Identification: coefficients of the model from tank trials, with their uncertainty.

names, coefficients: free coefficients, their bounds and scales, and robots with other values of them.
experiment, prediction: trials laid out for a fit, and their prediction with exact derivatives.
loss, residuals, trends: robust losses, errors of runs and their trends, lack of fit, information criteria.
estimator, profile: the estimator of tank and bench, and the profile likelihood.
angles, fixed: errors of joint angles in the coefficients, and of coefficients that are not free.
search, uncertainty, sentences, identify: the fit, its intervals and directions, sentences on them, and the whole.
truncated_normal, posterior: samples within the bounds.
tables, plots, cards: what is shown. image: a robot image with samples of its fit.
"""
