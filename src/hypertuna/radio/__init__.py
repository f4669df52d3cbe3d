"""MAVLink from the ground.

dialect (pymavlink's classes), client (connection and commands), parameters, calibration, log (MCAP), drive (by hand).
"""
