"""The twin: a robot simulated from servo pulses to wake, in the plane and at sea.

In reading order: `sea` (water, bottom, current), `plant` (the core's objects of a robot), `run` and `sea_run` (records
and what follows from them), `twin` (simulate a command), `dive` and `posture_test` (tests of the paper), `plots`,
`film` (the body in motion), `cards` (what notebooks show).
"""
