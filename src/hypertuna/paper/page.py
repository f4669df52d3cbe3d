"""The ledger as a self-contained page, with its plots and numbers in files beside it."""

import html
import json
from pathlib import Path
from typing import Any

from hypertuna.errors import InputError
from hypertuna.io.files import write_atomically
from hypertuna.paper.chapter import compose
from hypertuna.paper.chapters.gaits import ARITHMETIC
from hypertuna.paper.computed import OURS, PAPER, TWIN, bandwidths
from hypertuna.paper.ledger import CLASSES, MARKS, RULES, UNPUBLISHED, VERDICTS, Entry
from hypertuna.paper.reproduce import Ledger, ledger_record, ledger_sections
from hypertuna.reports.html import WIDTH, Fact, Picture, Section, page
from hypertuna.reports.studio import studio_page

# Verdict -> its name on the page; first word of an id -> title of its entries.
NAMES = dict(zip(VERDICTS, VERDICTS, strict=True)) | {"not-computed": "to come"}
TITLES = {"fe": "Finite elements", "start": "From rest"}
CARDS = tuple(  # for what readers may do next
    dict(zip(("title", "text", "command", "page"), card, strict=True))
    for card in (
        ("Swim", "The settled beat of a gait.", "hypertuna swim --gait unoptimised-max", "start/first-swim.md"),
        ("Optimize", "The fastest gait, or the cheapest one.", "hypertuna optimize --speed 0.4", "optimize.md"),
        ("Fit my trials", "Coefficients with intervals.", "hypertuna identify tank.csv", "howto/fit-trials.md"),
        ("Size pump and servo", "What limits the beat.", "hypertuna pump --bore 2:5:4", "howto/size-pump.md"),
        ("Bend a joint", "Soft joints under pressure.", "hypertuna joint bend --joint I", "howto/bend-joint.md"),
        ("Twin", "From command to wake.", "hypertuna twin --gait unoptimised-0.4", "twin.md"),
        ("Fly a mission", "Waypoints, currents, the way home.", "hypertuna mission box", "howto/fly-mission.md"),
        ("Drive by radio", "Keyboard, parameters, logs.", "hypertuna radio drive", "howto/drive-by-radio.md"),
        ("Firmware", "The same controller on board.", "hypertuna hil --board pc", "howto/build-firmware.md"),
    )
)
FRAME = "the page of the studio"  # placeholder in the template for the studio's page
CLOSED = ("coefficient", "optimum")  # groups of entries that are folded at first, as they repeat tables


def write_ledger(ledger: Ledger, folder: str | Path) -> Path:
    """Write the ledger as a folder: index.html, ledger.json and its plots as SVG."""
    folder = Path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        reason = f"not ({error.strerror})"
        raise InputError("must be a folder to write to", file=str(folder), value=reason, fix="choose another") from None
    sections = [*ledger_sections(ledger), *_robot(ledger)]
    for picture in (part for section in sections for part in section.parts if isinstance(part, Picture)):
        write_atomically(folder / f"{picture.name}.svg", picture.svg.encode())
    write_atomically(folder / "ledger.json", (json.dumps(ledger_record(ledger), indent=2) + "\n").encode())
    docs = "../docs" if (folder.parent / "docs/start/own-robot.md").is_file() else ""  # in a clone of the repository
    return write_atomically(folder / "index.html", ledger_html(ledger, sections, docs).encode())


def ledger_html(ledger: Ledger, sections: list[Section], docs: str = "") -> str:
    """Return the ledger as an HTML page that needs no other file; it links to a folder of `docs`, if given."""
    from hypertuna.swimming.outline import swimming_svg

    best = ledger.trials[OURS].gaits["unoptimised-max"]
    chapters = _chapters(ledger)
    count = sum(len(chapter["entries"]) for chapter in chapters)
    lede = """Describe your robotic fish in one file. Get its speed, power, cost of transport and turning radius in
milliseconds, with exact derivatives and a picture. Turn the knobs: this is HyperTuna, the first robot of the tool,
computed as you turn."""
    values = {"ledger": ledger, "chapters": chapters, "rules": RULES, "marks": MARKS, "names": NAMES}
    values |= {"classes": CLASSES, "count": count, "worth": _facts(ledger), "cards": CARDS, "docs": docs}
    values |= {"best": best, "fish": swimming_svg(best), "frame": FRAME}
    title = "hypertuna: a digital twin for robotic fish"
    text = page(title, sections, lede=lede, template="ledger.html.j2", values=values)
    # The studio is inserted last, as typography would damage its scripts.
    return text.replace(FRAME, html.escape(studio_page(best.robot, best.gait, ledger="")), 1)


def _chapters(ledger: Ledger) -> list[dict[str, Any]]:
    """Return the entries grouped by the first word of their id, then by id."""
    chapters: dict[str, dict[str, list[Entry]]] = {}
    for entry in ledger.entries:
        chapters.setdefault(entry.id.partition("/")[0], {}).setdefault(entry.id, []).append(entry)
    groups = []
    for name, entries in chapters.items():
        verdicts = [entry.verdict for group in entries.values() for entry in group]
        counts = {verdict: verdicts.count(verdict) for verdict in VERDICTS if verdict in verdicts}
        title = TITLES.get(name, name.replace("-", " ").capitalize())
        groups.append({"name": title, "entries": entries, "verdicts": counts, "open": name not in CLOSED})
    return groups


def _facts(ledger: Ledger) -> list[Fact]:
    """Return the few numbers that the page shows in large letters."""
    summary = ledger.summary
    errors, counts = summary["speeds"], summary["classes"]["prediction"]
    rms = {model: f"{100 * error['rms_relative_error']:.3g} %" for model, error in errors.items()}
    (distance,) = [entry for entry in ledger.entries if (entry.id, entry.model) == ("range/battery", ARITHMETIC)]
    predictions = sum(counts.values())
    unpredicted = len(ledger.entries) - predictions
    return [
        Fact(
            f"{summary['reproduced']} of {summary['predictions']}",
            f"predicted numbers are reproduced by at least one model, {summary['reproduced_measured']} of them a "
            f"measured number; of {predictions} predictions by all models, {counts['deviates'] + counts['violated']} "
            f"deviate, and {counts['undetermined']} are undetermined: {UNPUBLISHED}",
        ),
        Fact(
            f"{unpredicted}",
            f"other numbers are fitted, calibrated, chosen with the published one in view, inputs, at a bound, "
            f"or not judged: {summary['verdicts']['agrees'] - counts['agrees']} of them agree, which proves little",
        ),
        Fact(rms.get(TWIN, "–"), "rms error of the eight published speeds in the twin, from servo to wake"),
        Fact(
            rms[OURS],
            f"with a {bandwidths(ledger.trials[OURS].robot)} Hz joint bandwidth, fitted on four of them; "
            f"{rms[PAPER]} with ideal joints, the paper's own model",
        ),
        Fact(
            f"{distance.computed_text} km",
            f"range on the battery of the paper's Table I, where the paper claims {distance.published:g} km",
        ),
    ]


def _robot(ledger: Ledger) -> list[Section]:
    """Return the section with the figure of the robot."""
    from hypertuna.description.plots import plot_robot

    robot = ledger.trials[OURS].robot
    return compose("robot", {"robot": plot_robot(robot, width=WIDTH)}, robot=robot, links=sum(robot.links.mass))
