"""The twin: a robot simulated from servo pulses to wake, in the plane and at sea.

In reading order: `sea` (water, bottom, current), `plant` (the core's objects of a robot), `recorded` (what a run
records), `losses` (where its power goes), `run` and `sea_run` (a run and what follows from it), `twin` (simulate a
command), `dive` and `posture` (tests of the paper), `estimates` (robots within what is uncertain), `electrical`
(costs of a sweep), `plots`, `plots_losses`, `cards` (what is shown). `image`, `image_body`, `image_source`,
`image_text`: a robot for hosts without Python.
"""
