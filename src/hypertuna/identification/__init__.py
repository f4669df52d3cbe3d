"""Coefficients from trials, with uncertainty."""
