"""Identification: coefficients of the model from tank trials, with their uncertainty.

columns: columns of the model and of springs that can be free. names, coefficients: free coefficients, their bounds and
scales, and robots with given values of them.
experiment, prediction: arrange trials for a fit, and predict them with exact derivatives.
loss, residuals, trends: robust losses, errors of runs and their trends, lack of fit, information criteria.
estimator, profile: the estimator used for tank and bench, and the profile likelihood.
fixed: how errors of coefficients that are not free affect the fitted ones.
search, uncertainty, sentences: search for the fit; its intervals and directions, with errors of joint angles;
sentences on them. identify: the procedure from trials to a fit.
truncated_normal, posterior: samples within the bounds.
tables, plots, cards: tables, figures and cards. image: a robot image with samples of its fit.
"""
