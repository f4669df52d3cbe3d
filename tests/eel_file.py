"""The file of a robot of three links, and changes of it, as the tests of descriptions read it."""

EEL = """
format = 1
name = "eel"
description = "three links"

[body]
length_m = 0.6
mass_kg = 1.0

[links]
name = ["head", "middle", "tail"]
length_m = [0.3, 0.2, 0.1]
com_m = [0.15, 0.1, 0.05]
mass_kg = [0.5, 0.3, 0.1]
lateral_area_m2 = [0.03, 0.02, 0.01]
wetted_area_m2 = [0.06, 0.04, 0.02]

[[joints]]
name = "front"
links = [1]
bandwidth_hz = 3.0

[[joints]]
name = "rear"
links = [2]
amplitude_max_deg = 30.0

[model]
water = "strip"

[water]
density_kg_m3 = 1000.0

[water.strip]
added_mass_normal = [1.0, 1.0, 1.0]
added_mass_tangential = [0.0, 0.0, 0.0]
added_inertia = [1.0, 1.0, 1.0]
drag_normal = [2.0, 2.0, 2.0]
drag_tangential = [0.01, 0.01, 0.01]

[gaits.wave]
frequency_hz = 1.0
amplitude_deg = [10.0, 20.0]
phase_deg = [0.0, 90.0]

[sources]
"links" = "measured"
"links.com_m" = "estimate: middle"
"""


def edited(old: str, new: str) -> str:
    """Text of the test robot with one change, which must be possible."""
    assert EEL.count(old) >= 1
    return EEL.replace(old, new, 1)
