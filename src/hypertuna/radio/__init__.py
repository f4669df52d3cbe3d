"""The robot's radio from the side of the ground station, by MAVLink.

dialect (pymavlink's classes), client (connection and commands), parameters, calibration (straight lines), imu (its
calibration), samples (of sensors, for calibrations), check (before a swim), log (MCAP), calibration_procedure (with the
operator), drive (by hand).
"""
