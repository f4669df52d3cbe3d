"""One robot, described by robots/NAME.toml.

schema (tables and keys), robot (`load`, `Robot`, `require`), validation (places and words of errors), mistakes (all
errors of a file), plausibility (values that are unlikely), channels (kinds of sensors), commented (TOML with meanings),
shape (a fish from length and mass), drag and inversion (estimates of its drag, and of the speed at which its fins turn
it the other way), new (a first description), reference (docs page), provenance (what made a result), changes (values
set by key), following (what depends on a length or a mass), design (numbers of the file as variables), fin (the caudal
fin by span and chord), writer (a robot back into its file), twin (why a robot has none, and the command that writes one
that has), at_sea (what missions need, estimated), cards (what is shown of it), pose (where its links are), plots (its
figure).
"""
