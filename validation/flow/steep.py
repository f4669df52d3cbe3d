"""Normal force of plates at 10 to 60 deg of incidence: public measurements beside the strip law with and without H.

python validation/flow/steep.py prints the table of README.md. The law at a steady incidence a, on dynamic pressure and
area, with the lift slope 2 L and the added mass M of the lattice (fin.py) and the drag C_n across:

    C_N = 2 L F sin a cos a + C_n sin^2 a,   F = 1, H = cos a (the law), or M/(2L) + (1 - M/(2L)) H (form S)
"""

import json
import math
import runpy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

HERE = Path(__file__).parent
FORMS = runpy.run_path(str(HERE / "forms.py"))
LAWS = ("without H", "with H, the law", "form S")  # what `law` returns


def stored() -> list[dict[str, Any]]:
    """Return the measured series: name, source, aspect, drag across, incidences [deg], C_N."""
    record: list[dict[str, Any]] = json.loads((HERE / "steep.json").read_text())
    for series in record:
        if "lift" in series:
            angle = np.radians(series["incidence_deg"])
            lift, drag = np.array(series["lift"]), np.array(series["drag"])
            series["normal"] = (lift * np.cos(angle) + drag * np.sin(angle)).tolist()
        elif "fit" in series:
            series["normal"] = [FITS[series["fit"]](each, series["aspect"]) for each in series["incidence_deg"]]
    return record


def hoerner(degrees: float, aspect: float) -> float:
    """Return C_N of a stalled plate: Hoerner's fit with Lindenburg's correction for the aspect ratio."""
    sine = math.sin(math.radians(degrees))
    return 1.98 * (1 / (0.56 + 0.44 * sine) - 0.41 * (1 - math.exp(-17 / aspect))) * sine


def dickinson(degrees: float, _: float) -> float:
    """Return C_N of a flapping wing in mid-stroke (Dickinson, Lehmann and Sane 1999)."""
    lift = 0.225 + 1.58 * math.sin(math.radians(2.13 * degrees - 7.2))
    drag = 1.92 - 1.55 * math.cos(math.radians(2.04 * degrees - 9.82))
    return lift * math.cos(math.radians(degrees)) + drag * math.sin(math.radians(degrees))


# Fits to measurements, by name
FITS: dict[str, Callable[[float, float], float]] = {"hoerner": hoerner, "dickinson": dickinson}


def law(part: Any, drag: float, degrees: float) -> tuple[float, float, float]:
    """Return C_N without H, with H, and of form S."""
    sine, cosine = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
    share = min(part.mass / 2 / part.lift, 1.0)
    factors = 1.0, cosine, share + (1 - share) * cosine
    whole = [2 * part.lift * factor * sine * cosine + drag * sine**2 for factor in factors]
    return whole[0], whole[1], whole[2]


def rows() -> list[tuple[dict[str, Any], float, float, tuple[float, float, float]]]:
    """Return every measured point: its series, incidence, measured C_N and the C_N of each law."""
    found = []
    for series in stored():
        part = FORMS["Plate"](math.pi / 4 * series["added_mass"], series["lift_slope"] / 2, 0.0)
        for angle, normal in zip(series["incidence_deg"], series["normal"], strict=True):
            found.append((series, angle, normal, law(part, series["drag_normal"], angle)))
    return found


def main() -> None:
    """Print the table."""
    print(runpy.run_path(str(HERE / "table.py"))["steep"]())


if __name__ == "__main__":
    main()
