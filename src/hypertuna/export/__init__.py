"""Robots for other simulators.

In reading order: `link_water` (what the water is to each link), `outlook` (how it looks), `mjcf` and `mjcf_plugin`
(MuJoCo), `sdf` (Gazebo), `fmu_variables` and `fmu` (co-simulation); `xml` (elements and numbers).
"""
