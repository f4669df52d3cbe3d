"""The tables and keys of a robot file.

base (ranges, units, checks), body (body, links, joints, model, water, gaits), actuator (muscles, soft joints,
silicones), hydraulics (pump, oil, lines, servos, battery), spatial (links in space, fins), control (controller,
sensors), guidance (pilot), firmware (pins, limits).
"""
