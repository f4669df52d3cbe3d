"""A chapter of the ledger per module."""
