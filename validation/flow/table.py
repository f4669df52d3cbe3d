"""Write the tables of README.md from the stored results: python validation/flow/table.py [--check]"""

import json
import math
import re
import runpy
import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
STEPS = [2 * math.pi * i / 64 for i in range(64)]  # of a beat
MESHES = ("coarse", "medium", "fine")


def stored(name: str) -> Any:
    """Read stored results."""
    return json.loads((HERE / f"{name}.json").read_text())


def refined(row: dict[str, Any]) -> tuple[float, ...]:
    """Return a key by which rows go from coarse to fine within each KC, the usual choice of half the water last."""
    return row["kc"], MESHES.index(row["mesh"]), row["half"], -row["edge"], row["step"]


def finest() -> list[dict[str, Any]]:
    """Return the rows of oscillating.json on the finest mesh of each section and KC, plates first."""
    best = {(row["section"], row["kc"]): row for row in sorted(stored("oscillating"), key=refined)}
    return sorted(best.values(), key=lambda row: (row["section"] != "plate", row["section"], row["kc"]))


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
    """Return a section's name in the tables."""
    return name if name == "plate" else f"ellipse, b/a = {name}"


def spread(values: Sequence[float]) -> str:
    """Return the lowest and highest of the cycles' values as text."""
    return f"{min(values):.2f} to {max(values):.2f}"


def plates() -> str:
    """Tabulate plates beside fits to measurements."""
    head = ["KC", "mesh", "C_n", "of cycles", "Graham", "Luhar and Nepf", "their middle", "C_m", "of cycles"]
    rows = []
    for row in finest():
        if row["section"] == "plate":
            kc, (drag, mass) = row["kc"], (row["drag_normal"], row["added_mass_normal"])
            drags = [graham(kc), luhar(kc)[0], (graham(kc) + luhar(kc)[0]) / 2]
            fits = [(drag, fit) for fit in drags] + [(mass, luhar(kc)[1])]
            beside = [f"{fit:.2f} ({100 * (own / fit - 1):+.0f} %)" for own, fit in fits]
            cycles = [spread(row[key]) for key in ("drag_by_cycle", "added_mass_by_cycle")]
            numbers = [f"{drag:.2f}", cycles[0], *beside[:3], f"{mass:.2f}", cycles[1], beside[3]]
            rows.append([f"{kc:g}", row["mesh"], *numbers])
    return markdown([*head, "Luhar and Nepf"], rows)


def ellipses() -> str:
    """Tabulate ellipses beside the robot's file, whose C_n falls linearly from a flat plate's to a circle's."""
    rows = []
    for row in finest():
        if row["section"] != "plate":
            drag, mass, steady = row["drag_normal"], row["added_mass_normal"], 1.98 - 0.78 * float(row["section"])
            cycles = [spread(row[key]) for key in ("drag_by_cycle", "added_mass_by_cycle")]
            file = f"{steady:.2f} ({100 * (steady / drag - 1):+.0f} %)"
            numbers = [f"{row['kc']:g}", row["mesh"], f"{drag:.2f}", cycles[0], file, f"{mass:.2f}", cycles[1], "1.00"]
            rows.append([row["section"], *numbers])
    head = ["b/a", "KC", "mesh", "C_n", "of cycles", "robot's file", "C_m", "of cycles", "robot's file"]
    return markdown(head, rows)


def convergence() -> str:
    """Tabulate all runs by mesh, elements at edges and time step; rows not marked "half" mesh all of the water."""
    head = ["section", "KC", "mesh", "at the edges", "step", "unknowns", "C_n", "of cycles", "C_m", "of cycles"]
    rows = []
    for row in sorted(
        stored("oscillating"), key=lambda row: (row["section"] != "plate", row["section"], *refined(row))
    ):
        mesh = row["mesh"] + (", half" if row["half"] else "")
        numbers = [f"{row['edge']:g}", f"{row['step']:.2g}", f"{row['unknowns']:,}", f"{row['drag_normal']:.2f}"]
        found = [spread(row["drag_by_cycle"]), f"{row['added_mass_normal']:.2f}", spread(row["added_mass_by_cycle"])]
        rows.append([section(row["section"]), f"{row['kc']:g}", mesh, *numbers, *found, f"{row['cpu_s']}"])
    return markdown([*head, "time [s]"], rows)


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


def forms() -> dict[str, Any]:
    """Return the module of the forms."""
    return runpy.run_path(str(HERE / "forms.py"))


def compared() -> list[tuple[float, float, str, dict[str, tuple[float, float]]]]:
    """Return aspect ratio, k, motion, and thrust without suction and power of lattice, theory and each form."""
    module, record, found = forms(), stored("forms"), []
    parts = {row["aspect"]: module["Plate"](row["mass"], row["lift"], row["inertia"]) for row in record["plates"]}
    for name in module["MOTIONS"]:
        for row in record["stream"]:
            k, part = row["k"], parts[row["aspect"]]
            heave, pitch = module["motion"](name, k)
            sides = [[complex(*row[side][i : i + 2]) for i in (0, 2)] for side in ("heave", "pitch")]
            all_of = {"lattice": module["Response"](*(heave * a + pitch * b for a, b in zip(*sides, strict=True)))}
            for form in (*module["FORMS"], "Theodorsen"):
                all_of[form] = module["response"](form, part, k, heave, pitch)
            numbers = {who: module["thrust_and_power"](each, k, heave, pitch) for who, each in all_of.items()}
            found.append((row["aspect"], k, name, numbers))
    return found


def stream() -> str:
    """Tabulate thrust and power of the forms beside the lattice, and theory for infinite span."""
    head = [
        "motion",
        "b/c",
        "k",
        "thrust x1000: lattice",
        "theory, C(k)",
        "before",
        "S, P, quarter",
        "power x1000: lattice",
    ]
    rows = []
    for aspect, k, name, numbers in compared():
        infinite = aspect > 1e3
        thrusts = [f"{1000 * numbers[who][0]:.1f}" for who in ("lattice", "Theodorsen", "before", "P")]
        powers = [f"{1000 * numbers[who][1]:.3g}" for who in ("lattice", "Theodorsen")]
        over = [f"{numbers[who][1] / numbers['lattice'][1]:.2f}" for who in ("S", "P", "quarter")]
        for each in (thrusts, powers):
            each[1] = each[1] if infinite else ""
        rows.append([name, "infinite" if infinite else f"{aspect:g}", f"{k:g}", *thrusts, *powers, *over])
    return markdown([*head, "theory, C(k)", "S over lattice", "P", "quarter"], rows)


def lift_center() -> str:
    """Tabulate where the lift of a slowly pitching plate acts, in chords behind the leading edge."""
    rows = []
    record, module = stored("forms"), forms()
    for part in record["plates"]:
        row = next(r for r in record["stream"] if r["aspect"] == part["aspect"])
        ratio = part["mass"] / part["lift"]
        lever = module["Plate"](part["mass"], part["lift"], 0.0).lever
        at = [row["pitch"][2] / row["pitch"][0], 0.5 + 0.5 - ratio, 0.5 - ratio + lever, 0.25]
        name = "infinite" if part["aspect"] > 1e3 else f"{part['aspect']:g}"
        rows.append([name, f"{ratio:.3f}", *(f"{each:.2f}" for each in at)])
    return markdown(["b/c", "M/L", f"lattice, k = {record['stream'][0]['k']:g}", "S", "P", "quarter"], rows)


def still() -> str:
    """Tabulate the thrust in still water over Lighthill's: two lattices and their extrapolation."""
    rows = []
    for row in stored("forms")["still"]:
        angle = math.radians(row["pitch_deg"])
        finite = [
            f"{3 * fine - 2 * coarse:.2f} ({coarse:.2f}, {fine:.2f})" for coarse, fine in (row["normal"], row["thrust"])
        ]
        # mean of w^2 cos(angle) over that of w^2, for a harmonic angle
        turned = sum(math.cos(t) ** 2 * math.cos(angle * math.sin(t)) for t in STEPS) / sum(
            math.cos(t) ** 2 for t in STEPS
        )
        rows.append([f"{row['aspect']:g}", f"{row['pitch_deg']:g}", *finite, f"{turned:.2f}", "0.00"])
    return markdown(["b/c", "pitch [deg]", "lattice, normal force", "with suction", "S, P, quarter", "before"], rows)


def attached() -> str:
    """Tabulate the normal force of attached flow beside the law's lift."""
    record, rows = stored("forms"), []
    lift = {row["aspect"]: row["lift"] for row in record["plates"]}
    for row in record["steady"]:
        law = lift[row["aspect"]] * math.sin(2 * math.radians(row["incidence_deg"]))
        numbers = [f"{row['normal']:.2f}", f"{law:.2f}", f"{row['center']:.2f}"]
        rows.append([f"{row['aspect']:g}", f"{row['incidence_deg']:g}", *numbers])
    return markdown(["b/c", "incidence [deg]", "C_N, lattice", "2 L sin a cos a", "acts at [chords]"], rows)


def steep() -> str:
    """Tabulate measured plates at large incidences beside the law."""
    module, rows = runpy.run_path(str(HERE / "steep.py")), []
    for series, angle, normal, laws in module["rows"]():
        over = [f"{each:.2f} ({100 * (each / normal - 1):+.0f} %)" for each in laws]
        rows.append([series["series"], f"{series['drag_normal']:g}", f"{angle:g}", f"{normal:.2f}", *over])
    return markdown(["plate", "C_n", "incidence [deg]", "C_N measured", *module["LAWS"]], rows)


TABLES: dict[str, Callable[[], str]] = {
    each.__name__: each
    for each in (
        plates,
        ellipses,
        convergence,
        infinite_span,
        fin,
        stream,
        lift_center,
        still,
        attached,
        steep,
        travel,
        speeds,
    )
}


def written(text: str) -> str:
    """Return a page's text with its tables filled in."""
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
