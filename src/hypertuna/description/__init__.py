"""One robot, described by robots/NAME.toml.

schema (tables and keys), robot (`load`, `Robot`, `require`), validation (places and texts of errors), mistakes (all
errors of a file), plausibility (unlikely values), channels (kinds of sensors), commented (TOML with comments), shape (a
fish from length and mass), drag and inversion (estimates of drag, and of the speed at which fins act in reverse), new
(a first description), reference (the schema in words), provenance (version, robot and options behind a result), changes
(values set by key), following (values that depend on a length or a mass), design (numbers of the file as variables),
fin (the caudal fin by span and chord), writer (a robot back into its file), twin (why a robot has no twin), at_sea
(estimated tables for missions), cards (results as text), pose (positions of the links), plots (the figure).
"""
