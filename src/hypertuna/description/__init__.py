"""One robot, described by robots/NAME.toml.

schema (tables and keys), robot (`load`, `Robot`, `require`), validation (errors in one sentence),
reference (docs page), provenance (what made a result), writer (a robot back into its file), card (what notebooks show).
"""
