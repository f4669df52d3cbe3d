"""Robots for other simulators.

In reading order: `link_water` (added mass and drag of each link), `outlook` (shapes for the picture), `mjcf` and
`mjcf_plugin` (MuJoCo), `sdf` (Gazebo), `fmu_variables` and `fmu` (co-simulation); `xml` (elements and numbers).
"""
