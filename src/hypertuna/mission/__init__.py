"""Missions: from a file with waypoints to a flight, its log and its figures.

In reading order: `schema` and `file` (the TOML file), `geodesy` (latitude and longitude), `magnetic` (declination),
`checks` (what a robot cannot do), `mishaps` (what happens to a robot's body and drives), `run` (part by part on the
twin at sea), `flight` (one seed with journal and log, or many, and which waypoints were reached), `seeds` (many, into a
table or shards), `image` (a robot with its missions), `record` (the time series), `log_fields`, `log` and `read_log`
(MCAP), `foxglove` (its layout), `gpx` (tracks for maps), `plots`, `cards` (what is shown), `upload` (to a robot by
radio). Where files come from: `new` (a mission for a robot); `plans`, `plan_items` and `import_plan` (plans of other
programs).
"""
