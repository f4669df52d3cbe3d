"""Soft joints, their hydraulics and the battery.

`silicone`: elastic constants from tensile tests. `soft_joint`: joints for the core and as tables. `axis`: what
holds their axis. `bending`: bend under pressure. `hydraulics`: pump, oil and lines. `sizing`: pump sizes. `battery`:
range and endurance. `tail`: tails that yield. `new`: a first robot file. `plots`: figures; `cards`: what is shown.
"""
