"""What is shown of the bend of a joint by finite elements."""

from functools import partial

import numpy as np

from hypertuna.display import Card, Facts, cards, number
from hypertuna.fe.bend import FeBend
from hypertuna.pictures import curve_svg


@cards.of(FeBend)
def fe_card(bend: FeBend) -> Card:
    """Show the largest bend, and the curve of the angle over the pressure."""
    angle, pressure = np.degrees(bend.angle), bend.pressure / 1e3
    facts = {"bend": f"{number(angle[-1], 'deg')} at {number(pressure[-1], 'kPa')}"} if len(angle) else {}
    facts |= {"elements": f"{bend.elements}", "unknowns": f"{bend.unknowns}", "material set": bend.material}
    title = f"Joint {bend.joint} of {bend.robot.name} by finite elements, pressure on the {bend.side} side"
    picture = partial(curve_svg, pressure, angle, "bend [deg] over pressure [kPa]", dots=True)
    return Card(title, [Facts(facts), bend.status_text], picture)
