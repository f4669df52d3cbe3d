"""The schema of a robot file, a module per group of tables."""
