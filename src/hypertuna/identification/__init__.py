"""Identification: coefficients of the model from tank trials, with their uncertainty.

columns: columns of the model and of springs that can be free. names, coefficients: free coefficients, their bounds and
scales, and robots with given values of them.
experiment, prediction: arrange trials for a fit, and predict them with exact derivatives.
loss, residuals, trends: robust losses, errors of runs and their trends, lack of fit, information criteria.
estimator, profile: the estimator used for tank and bench, and the profile likelihood.
angles, fixed: how errors of joint angles, and of coefficients that are not free, affect the fitted coefficients.
search, uncertainty, sentences, identify: search the fit; its intervals and directions; sentences on these; the whole.
truncated_normal, posterior: samples within the bounds.
tables, plots, cards: tables, figures and cards. image: a robot image with samples of its fit.
"""
