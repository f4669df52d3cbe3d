"""Files whole or not at all, tables, checkpoints, MCAP, what ships with the package."""
