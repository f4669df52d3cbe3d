"""Make bench runs as a test bench would: both joints bent both ways and back, with noise drawn by a seed.

`python make.py` writes bench.csv beside itself. The actuator on this bench is not the described one: `TRUTH` says what
it is, so that a fit can be held against it. Nothing here was measured.
"""

import sys
from pathlib import Path

import numpy as np

import hypertuna as ht
from hypertuna.actuation.bending import bend
from hypertuna.characterization.unknowns import unknowns, with_unknowns

SEED = 1
ANGLE_NOISE = 0.2  # deg
VOLUME_NOISE = 0.01  # ml
MISREAD = 17, 3.0  # row, and by how many degrees it was read wrong, as happens
PRESSURES = np.linspace(50e3, 250e3, 5)  # Pa

# Over what is described: the levers are longer, the matrix is softer, the hose is thinner, the braids rub more.
TRUTH = {
    "lever[I]": 1.1,
    "lever[II]": 1.15,
    "stiffness_factor[I]": 1.2,
    "matrix_modulus": 0.8,
    "hose_modulus": 0.85,
    "outer_diameter": 0.95,
    "braid_angle": 1.03,
    "asymmetry[I]": 0.95,
    "friction": 1.5,
}

described = ht.load("hypertuna")
frees = unknowns(described, (0, 1), names=list(TRUTH))
actual = with_unknowns(described, frees, np.array([one.described * TRUTH[one.name] for one in frees]))
random = np.random.default_rng(SEED)
folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent

rows = []
for joint in ("I", "II"):
    for side in ("left", "right"):
        loop = bend(actual, joint, PRESSURES, side=side, unload=True)
        both = zip(
            np.append(PRESSURES, PRESSURES[::-1]), np.append(loop.angle, loop.unload_angle), loop.volume, strict=True
        )
        for k, (pressure, angle, volume) in enumerate(both):
            branch = "load" if k < len(PRESSURES) else "unload"
            measured = np.degrees(angle) + ANGLE_NOISE * random.standard_normal()
            measured += MISREAD[1] * (len(rows) == MISREAD[0])
            # the syringe was on joint I's left side only
            oil = 1e6 * volume + VOLUME_NOISE * random.standard_normal()
            cell = f"{oil:.3f}" if (joint, side, branch) == ("I", "left", "load") else ""
            rows.append(f"{joint},{side},{branch},{pressure / 1e3:g},{measured:.2f},{cell}")

head = "joint,side,branch,pressure_kpa,angle_deg,volume_ml"
text = "\n".join(["# synthetic: made by make.py, not measured", head, *rows])
(folder / "bench.csv").write_text(f"{text}\n", encoding="utf-8")
