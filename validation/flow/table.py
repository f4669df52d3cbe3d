"""Write the tables of README.md from oscillating.json: python validation/flow/table.py [--check]"""

import json
import sys
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
MARK = "<!-- rows of oscillating.json, written by `python table.py` -->\n"
USUAL = {"mesh": "coarse", "step": 1e-3, "reynolds": 1000.0}


def rows() -> list[dict[str, Any]]:
    """Read the rows."""
    result: list[dict[str, Any]] = json.loads((HERE / "oscillating.json").read_text())
    return result


def usual(row: dict[str, Any]) -> bool:
    """Return whether a row has the choices of the main table."""
    return all(row[key] == value for key, value in USUAL.items())


def graham(kc: float) -> float:
    """Return the drag coefficient of a plate, 8 KC^(-1/3)."""
    return 8 * kc ** (-1 / 3)


def tables() -> str:
    """Return the tables in Markdown."""
    lines = ["| section | KC | C_n | 8 KC^(-1/3) | difference | C_m | explained | time [s] |", "|---|" + "---:|" * 7]
    for row in sorted(filter(usual, rows()), key=lambda row: (row["section"] != "plate", row["section"], row["kc"])):
        plate = row["section"] == "plate"
        beside = (
            f"{graham(row['kc']):.2f} | {100 * (row['drag_normal'] / graham(row['kc']) - 1):+.0f} %" if plate else "|"
        )
        name = "plate" if plate else f"ellipse, b/a = {row['section']}"
        cells = f"{row['drag_normal']:.2f} | {beside} | {row['added_mass_normal']:.2f} | {100 * row['explained']:.1f} %"
        lines.append(f"| {name} | {row['kc']:g} | {cells} | {row['cpu_s']} |")
    lines += ["", "Mesh, step and Reynolds number:", ""]
    lines += ["| section | KC | mesh | unknowns | step | Reynolds number | C_n | C_m |", "|---|---:|---|" + "---:|" * 5]
    several = {(row["section"], row["kc"]) for row in rows() if not usual(row)}
    for row in rows():
        if (row["section"], row["kc"]) in several:
            numbers = f"{row['unknowns']:,} | {row['step']:g} | {row['reynolds']:g}"
            found = f"{row['drag_normal']:.2f} | {row['added_mass_normal']:.2f}"
            lines.append(f"| {row['section']} | {row['kc']:g} | {row['mesh']} | {numbers} | {found} |")
    return "\n".join(lines) + "\n"


def main() -> None:
    """Write the page, or compare it."""
    page = HERE / "README.md"
    text = page.read_text()
    new = text[: text.index(MARK) + len(MARK)] + "\n" + tables()
    if "--check" in sys.argv:
        sys.exit(0 if new == text else "README.md is not that of oscillating.json: run table.py")
    page.write_text(new)


if __name__ == "__main__":
    main()
