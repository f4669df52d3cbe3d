"""The twin: a robot simulated from servo pulses to wake, in the plane and at sea.

In reading order: `sea` (water, bottom, current), `plant` (the core's objects of a robot), `recorded` (the quantities
that a run records), `series` (values between its ticks), `losses` (where its power goes), `run` and `sea_run` (the
record of a run and its means), `twin` (simulate a command), `dive` and `posture` (tests of the paper), `estimates`
(robots with other values of uncertain keys), `electrical` (electrical costs of a sweep's gaits), `plots`,
`plots_losses`, `cards` (figures and cards).
`image`, `image_body`, `image_source`, `image_text`: a robot for hosts without Python.
"""
