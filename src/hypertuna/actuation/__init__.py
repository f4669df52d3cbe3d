"""Soft joints, their hydraulics and the battery.

`silicone`: elastic constants from tensile tests. `soft_joint`: joints for the core and as tables. `axis`: films and
pipes that hold a joint's axis. `bending`: bend under pressure. `hydraulics`: pump, oil and lines. `sizing`: pump sizes.
`battery`: range and endurance. `tail`: passive and flexible tails. `new`: a first robot file. `plots`: figures.
`cards`: results as text.
"""
