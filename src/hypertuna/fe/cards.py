"""Cards of a joint's bend by finite elements, of the comparison with the fast model, and of joint maps."""

import math
from collections.abc import Iterable, Mapping
from functools import partial

import numpy as np

from hypertuna.display import Card, Part, Table, cards
from hypertuna.fe.bend import FeBend
from hypertuna.fe.comparison import FeComparison
from hypertuna.fe.joint_map import JointMap
from hypertuna.pictures import curve_svg

# Columns of the tables: key of a step's record, head and format.
BEND_COLUMNS = {
    "pressure_kpa": ("gauge\n[kPa]", ".4g"),
    "bend_deg": ("bend\n[deg]", "z.2f"),
    "tip_x_mm": ("tip x\n[mm]", "z.2f"),
    "tip_y_mm": ("tip y\n[mm]", "z.2f"),
    "oil_taken_ml": ("oil\n[ml]", "z.3f"),
    "axial_stretch_min": ("axial\nmin", ".3f"),
    "hoop_stretch_max": ("hoop\nmax", ".3f"),
    "fiber_stretch_max": ("fiber\nmax", ".3f"),
    "strain_99": ("strain\n99 %", "z.3f"),
    "strain_max": ("\nmax", "z.3f"),
    "stress_99_kpa": ("stress\n[kPa]", "z.1f"),
    "stress_max_kpa": ("\nmax", "z.1f"),
}
BEND_LEGEND = (
    "Bend, and oil since rest, of the side under pressure; stretches of the channels' walls and of the braids; "
    "logarithmic strain and von Mises stress of the matrix: the 99th percentile, and the maximum, which sits where "
    "hoses end and grows as meshes get finer."
)
COMPARISON_COLUMNS = {
    "pressure_kpa": ("gauge\n[kPa]", ".4g"),
    "bend_fe_deg": ("bend FE\n[deg]", "z.2f"),
    "bend_analytic_deg": ("model\n[deg]", "z.2f"),
    "bend_difference_percent": ("differs\n[%]", "+z.1f"),
    "oil_fe_ml": ("oil FE\n[ml]", "z.3f"),
    "oil_analytic_ml": ("model\n[ml]", "z.3f"),
    "oil_difference_percent": ("differs\n[%]", "+z.1f"),
    "shortening_percent": ("shorter FE\n[%]", "z.1f"),
    "shortening_analytic_percent": ("model\n[%]", "z.1f"),
}
COMPARISON_LEGEND = (
    "Bend, and oil taken in since rest, of the side under pressure, and shortening of the axis: by finite elements "
    "(FE), without friction; by the fast model, with the friction of the description, loading; and the difference of "
    "the model from FE."
)


@cards.of(FeBend)
def fe_card(bent: FeBend) -> Card:
    """Show a bend by finite elements, with a row for each pressure."""
    options, record = bent.options, bent.record()
    size = f"{record['mesh']} mesh, {bent.elements} elements, {bent.unknowns} unknowns, {record['seconds']:.0f} s"
    parts: list[Part] = [(f"{options.law}, {size}, Poisson's ratio {options.poisson:g}", "dim")]
    parts += [_step_table(BEND_COLUMNS, record["steps"]), (BEND_LEGEND, "dim")]
    if np.isfinite(squared := bent.r_squared()):
        parts.append(f"line over 100 to 250 kPa: R^2 = {squared:.4f}")
    label = "bend [deg] over pressure [kPa]"
    picture = partial(curve_svg, bent.pressure / 1e3, np.degrees(bent.angle), label, dots=True)
    return Card(_title(bent), [*parts, outcome(bent)], picture)


@cards.of(FeComparison)
def comparison_card(compared: FeComparison) -> Card:
    """Show finite elements beside the fast model, with a row for each pressure."""
    bent, record = compared.fe, compared.record()
    size = f"{record['mesh']} mesh, {bent.elements} elements, {record['seconds']:.0f} s"
    parts: list[Part] = [(size, "dim"), _step_table(COMPARISON_COLUMNS, record["steps"]), (COMPARISON_LEGEND, "dim")]
    squares = (bent.r_squared(), compared.analytic.r_squared())
    if np.isfinite(squares).all():
        parts.append(f"line over 100 to 250 kPa: R^2 = {squares[0]:.4f} (FE), {squares[1]:.4f} (fast model)")
    if compared.reasons:
        parts.append(f"From the fast model to finite elements, {bent.pressure[-1] / 1e3:g} kPa:")
        angles = [reason["bend_deg"] for reason in record["reasons"]]
        changes = ["" if math.isnan(change) else f"{change:+.2f}" for change in np.diff([math.nan, *angles])]
        bends = ["not found" if math.isnan(angle) else f"{angle:.2f}" for angle in angles]
        rows = [*zip((reason.text for reason in compared.reasons), bends, changes, strict=True)]
        parts.append(Table(["", "bend\n[deg]", "change\n[deg]"], rows, tight=True))
    return Card(_title(bent), [*parts, outcome(bent)])


def _title(bent: FeBend) -> str:
    """Return the title of a bend: robot, joint, side and material set."""
    return f"{bent.robot.name}: joint {bent.joint}, {bent.side} side, material set {bent.material}"


def _step_table(columns: Mapping[str, tuple[str, str]], steps: Iterable[Mapping[str, float]]) -> Table:
    """Return a table with a row for each step of a record; cells of NaN are empty."""
    forms = {key: form for key, (_, form) in columns.items()}
    rows = [["" if math.isnan(step[key]) else f"{step[key]:{form}}" for key, form in forms.items()] for step in steps]
    return Table([head for head, _ in columns.values()], rows, left=(), tight=True)


def outcome(bent: FeBend) -> tuple[str, str]:
    """Return the sentence on how a run ended, and its style."""
    return bent.status_text, "green" if bent.status == "converged" else "bold red"


@cards.of(JointMap)
def map_card(found: JointMap) -> Card:
    """Show a joint map, with a row for each point: finite elements and fast model side by side."""
    header = ["left\n[kPa]", "right\n[kPa]", "moment\n[N m]"]
    header += [f"{name}\n[{unit}]" for name, unit in (("bend FE", "deg"), ("oil left", "ml"), ("right", "ml"))]
    header += ["length\n[mm]", "model\n[deg]", "left\n[ml]", "right\n[ml]", "length\n[mm]"]
    rows = []
    for c, p in np.ndindex(found.elements.angle.shape):
        row = [f"{pressure / 1e3:.4g}" for pressure in found.pressure[p]]
        if not np.isfinite(found.elements.angle[c, p]):
            rows.append([*row, "", "not found", *[""] * 7])
            continue
        row.append(f"{found.elements.moment[c, p]:+z.3f}")
        for states in (found.elements, found.model):
            oil = (f"{1e6 * volume:.3f}" for volume in states.volume[c, p])
            row += [f"{np.degrees(states.angle[c, p]):z.2f}", *oil, f"{1e3 * states.length[c, p]:.2f}"]
        rows.append(row)
    moment, volume = 100 * found.moment_difference, 100 * found.volume_difference
    text = f"moments of the fast model differ by at most {moment:.1f} % of the {found.straight:.3g} N m of the straight"
    parts: list[Part] = [
        Table(header, rows, left=(), tight=True),
        f"{text} joint, volumes by {volume:.1f} % of their range",
        (found.status_text, "green" if found.status == "converged" else "bold yellow"),
    ]
    return Card(f"{found.robot.name}: joint {found.joint}, mesh {found.options.mesh}", parts)
