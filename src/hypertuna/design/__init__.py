"""Experimental design: the run that a tank should make next, the one expected to narrow the uncertainty most.

unknowns: coefficients with their prior, from a fit or from handbooks. kinds: kinds of runs that a tank can make. runs:
runs and their results. prediction: logarithms of measured quantities, with exact derivatives. discrepancy: the error of
the model, and offsets of days. posterior: the refit after each run. criterion: the choice of the next run. steps: the
runs made so far, and warnings. tank: the state in a file. cards, plots: what is shown.
"""
