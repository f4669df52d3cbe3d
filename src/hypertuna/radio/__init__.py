"""The ground station's side of the radio, by MAVLink.

dialect (pymavlink's classes), client (connection and commands), parameters (read and set), calibration (fits of
straight lines), imu (calibration of the IMU), samples (sensor readings for calibrations), check (before a swim), log
(MCAP files), calibration_procedure (steps with the operator), drive (manual driving).
"""
