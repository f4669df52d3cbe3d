"""Experimental design: the run that a tank should make next, the one expected to narrow the uncertainty most.

unknowns: coefficients with their prior, of a fit and of handbooks. kinds: kinds of runs that a tank can make. runs:
such runs, and their results. prediction: logarithms of what runs measure, with exact derivatives. discrepancy: what the
model misses, and offsets of days. posterior: the refit after each run. criterion: the choice of the next run. steps:
runs that were made, and what they warn of. checks: results that are refused. tank: the state in a file. cards, plots:
what is shown.
"""
