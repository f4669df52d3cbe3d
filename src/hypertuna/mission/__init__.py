"""Missions: from a file with waypoints to a flight, its log and its figures.

In reading order: `schema` and `file` (the TOML file), `geodesy` (latitude, longitude and magnetic declination),
`checks` (whether a robot can fly a mission), `mishaps` (faults of body and drives), `run` (fly part by part on the twin
at sea), `flight` (fly one seed with journal and log; its outcome), `seeds` (many seeds, into a table or shards),
`image` (a robot with its missions), `record` (the time series), `log_fields`, `log` and `read_log` (MCAP files),
`foxglove` (layout of the log), `gpx` (tracks for maps), `plots` and `cards` (figures and cards), `upload` (send to a
robot by radio). Making mission files: `new` (a mission for a robot); `plans`, `plan_items` and `import_plan` (plans of
other programs).
"""
