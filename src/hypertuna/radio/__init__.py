"""MAVLink from the ground: dialect, client, parameters, calibration, log, drive."""
