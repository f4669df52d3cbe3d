"""What notebooks and shells show of the bend of a joint and of pump sizes."""

import numpy as np

from hypertuna.actuation.bending import Bend
from hypertuna.actuation.sizing import Sizes
from hypertuna.display import Card, number
from hypertuna.pictures import captioned, curve_svg


def sizes_card(sizes: Sizes) -> Card:
    """Show what bend and power each case of a pump gives."""
    columns = ("joint", "frequency", "bore", "bend", "of", "power", "largest pressure", "limits")
    rows = [
        (
            size.joint,
            number(size.frequency, "Hz"),
            number(1e3 * size.bore, "mm"),
            number(float(np.degrees(size.bend)), "deg"),
            number(float(np.degrees(size.command)), "deg"),
            number(size.electrical_power["total"], "W"),
            number(size.pressure_max / 1e3, "kPa"),
            ", ".join(size.limits) or "none",
        )
        for size in sizes
    ]
    return Card(f"Pump: {len(sizes)} cases", (), "", columns, rows, lambda: _loads_svg(sizes))


def _loads_svg(sizes: Sizes) -> str:
    """Draw the servo's torque and speed of each case, and the line between the limits of both."""
    torque = [100 * size.torque / size.torque_limit for size in sizes]
    speed = [100 * size.servo_speed / size.servo_speed_limit for size in sizes]
    label = "servo torque [% of stall] over servo speed [% of that without load]"
    text = "Each dot is a case: torque at the pressure limit, largest speed. Dashed: what the servo gives."
    return captioned(curve_svg(speed, torque, label, dots=True, dashed=[[(0, 100), (100, 0)]]), text)


def bend_card(bend: Bend) -> Card:
    """Show the largest bend, how linear it is, and the curve of the angle over the pressure."""
    angle, pressure = np.degrees(bend.angle), bend.pressure / 1e3
    facts = [
        ("bend", f"{number(float(angle[-1]), 'deg')} at {number(float(pressure[-1]), 'kPa')}"),
        ("linearity R²", number(bend.r_squared() if len(angle) > 1 else np.nan)),
        ("friction loss", number(bend.friction_loss if bend.unload_angle is not None else np.nan, "J")),
        ("shortening", number(100 * float(bend.shortening.max()), "%")),
        ("max braid angle", number(float(np.degrees(bend.braid_angle_max)), "deg")),
        ("material set", bend.material),
    ]

    def picture() -> str:
        ways = bend.branches.values()
        x, y = (np.concatenate(part) for part in zip(*ways, strict=True))
        return curve_svg(x / 1e3, np.degrees(y), "bend [deg] over pressure [kPa]")

    title = f"Joint {bend.joint} of {bend.robot.name}, pressure on the {bend.side} side"
    return Card(title, facts, bend.status_text, picture=picture)
