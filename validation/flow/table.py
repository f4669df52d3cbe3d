"""Write the tables of README.md from the stored results: python validation/flow/table.py [--check]"""

import json
import math
import re
import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
USUAL = {"mesh": "coarse", "step": 1e-3, "reynolds": 1000.0}


def stored(name: str) -> Any:
    """Read stored results."""
    return json.loads((HERE / f"{name}.json").read_text())


def usual(row: dict[str, Any]) -> bool:
    """Return whether a row of oscillating.json has the choices of the main table."""
    return all(row[key] == value for key, value in USUAL.items()) and not row.get("half")


def graham(kc: float) -> float:
    """Return the drag coefficient of plates after Graham (1980)."""
    return 8 * kc ** (-1 / 3)


def luhar(kc: float) -> tuple[float, float]:
    """Return drag and added mass of plates after Luhar and Nepf (2016), for KC of 1.7 to 11."""
    return 10 * kc ** (-1 / 3), 1 + 0.35 * kc ** (2 / 3)


def markdown(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table in Markdown."""
    lines = [head, ["---", *["---:"] * (len(head) - 1)], *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines) + "\n"


def section(name: str) -> str:
    """Name a section."""
    return name if name == "plate" else f"ellipse, b/a = {name}"


def spread(values: Sequence[float]) -> str:
    """Write the lowest and highest of the cycles."""
    return f"{min(values):.2f} to {max(values):.2f}"


def plates() -> str:
    """Tabulate plates and ellipses beside fits to measurements."""
    head = ["section", "KC", "C_n", "of cycles", "Graham", "Luhar and Nepf", "C_m", "of cycles", "Luhar and Nepf"]
    rows = []
    chosen = sorted(filter(usual, stored("oscillating")), key=lambda row: (row["section"] != "plate", row["kc"]))
    for row in chosen:
        kc, (drag, mass) = row["kc"], (row["drag_normal"], row["added_mass_normal"])
        beside = [""] * 3
        if row["section"] == "plate":
            fits = [(drag, graham(kc)), (drag, luhar(kc)[0]), (mass, luhar(kc)[1])]
            beside = [f"{fit:.2f} ({100 * (own / fit - 1):+.0f} %)" for own, fit in fits]
        cycles = [spread(row[key]) for key in ("drag_by_cycle", "added_mass_by_cycle")]
        numbers = [f"{drag:.2f}", cycles[0], *beside[:2], f"{mass:.2f}", cycles[1], beside[2]]
        rows.append([section(row["section"]), f"{kc:g}", *numbers])
    return markdown(head, rows)


def convergence() -> str:
    """Tabulate the runs with other meshes, steps and Reynolds numbers."""
    head = ["section", "KC", "mesh", "unknowns", "step", "Reynolds number", "C_n", "of cycles", "C_m", "of cycles"]
    head += ["time [s]"]
    several = {(row["section"], row["kc"]) for row in stored("oscillating") if not usual(row)}
    chosen = [row for row in stored("oscillating") if (row["section"], row["kc"]) in several]
    chosen.sort(key=lambda row: (row["kc"], row.get("half", False), row["reynolds"], row["unknowns"], -row["step"]))
    rows = []
    for row in chosen:
        numbers = [f"{row['unknowns']:,}", f"{row['step']:g}", f"{row['reynolds']:g}", f"{row['drag_normal']:.2f}"]
        found = [spread(row["drag_by_cycle"]), f"{row['added_mass_normal']:.2f}", spread(row["added_mass_by_cycle"])]
        found.append(f"{row['cpu_s']}")
        mesh = row["mesh"] + (", half" if row.get("half") else "")
        rows.append([section(row["section"]), f"{row['kc']:g}", mesh, *numbers, *found])
    return markdown(head, rows)


def infinite_span() -> str:
    """Tabulate plates of infinite span beside theory."""
    head = ["k", "heave", "pitch [rad]", "lead [deg]", "side force, of theory", "thrust", "theory", "suction", "theory"]
    rows = []
    for row in stored("wake")["infinite_span"]:
        side = f"{row['side_force_ratio']:.3f}, {row['side_force_lead_deg']:+.1f} deg"
        motion = [f"{row[key]:g}" for key in ("reduced", "heave", "pitch")] + [f"{math.degrees(row['lead']):.0f}"]
        forces = [f"{row[key]:.5f}" for key in ("thrust", "thrust_theory", "suction", "suction_theory")]
        rows.append([*motion, side, *forces])
    return markdown(head, rows)


def fin() -> str:
    """Tabulate the fin in the gaits beside the strip law."""
    head = ["gait", "motion", "k", "incidence up to [deg]", "thrust: law", "lattice, no suction", "law, suction 1"]
    head += ["lattice, suction", "normal rms: law", "lattice", "edge lift", "added mass", "explained"]
    rows = []
    for row in stored("wake")["fin"]:
        how = f"{100 * row['scale']:.0f} %" + (", free wake" if row["free"] else "")
        how += ", fine" if row["panels"][0] > 4 else ""
        forces = [f"{row[key]:.3g}" for key in ("thrust_law", "thrust_normal", "thrust_law_suction", "thrust")]
        forces += [f"{row[key]:.3g}" for key in ("normal_rms_law", "normal_rms")]
        fit = [f"{row['edge_lift']:.2f}", f"{row['added_mass']:.2f}", f"{100 * row['explained']:.1f} %"]
        rows.append([f"`{row['gait']}`", how, f"{row['reduced']:.2f}", f"{row['incidence_deg']:.0f}", *forces, *fit])
    return markdown(head, rows)


def travel() -> str:
    """Tabulate the Keulegan-Carpenter numbers of the links."""
    record = stored("law")
    head = ["KC of the middle", *record["links"]]
    rows = []
    for name, part in (("head held still", 0), ("swimming", 1)):
        each = list(zip(*(gait[part] for gait in record["kc"]), strict=True))
        rows.append([name, *(f"{min(link):.1f} to {max(link):.1f}" for link in each)])
    return markdown(head, rows)


def speeds() -> str:
    """Tabulate the errors of the eight speeds."""
    rows = []
    for name, found in stored("law")["errors"].items():
        each = ", ".join(f"{error:+.0f}" for error in found["bandwidth"])
        sizes = [math.sqrt(sum(e * e for e in found[joints]) / len(found[joints])) for joints in ("bandwidth", "ideal")]
        rows.append([name, each, *(f"{size:.0f}" for size in sizes)])
    return markdown(["strips", "errors, joints of 4.7 Hz [%]", "rms [%]", "rms, ideal joints [%]"], rows)


TABLES: dict[str, Callable[[], str]] = {
    each.__name__: each for each in (plates, convergence, infinite_span, fin, travel, speeds)
}


def written(text: str) -> str:
    """Return a page with its tables computed."""
    pattern = re.compile(r"(<!-- table: (\w+) -->\n).*?(<!-- end -->)", re.DOTALL)
    return pattern.sub(lambda match: f"{match[1]}\n{TABLES[match[2]]()}\n{match[3]}", text)


def main() -> None:
    """Write the page, or compare it."""
    page = HERE / "README.md"
    text = page.read_text()
    if "--check" in sys.argv:
        sys.exit(0 if written(text) == text else "README.md is not that of the stored results: run table.py")
    page.write_text(written(text))


if __name__ == "__main__":
    main()
