"""The tables and keys of a robot file.

base (ranges, units, checks), body (body, links in the plane and in space, fins, joints, gaits), actuator (muscles,
soft joints, silicones), hydraulics (pump, oil, lines, servos, battery), water (laws), control (controller, sensors,
guidance), firmware (pins, limits), fit (what an identification writes).
"""
