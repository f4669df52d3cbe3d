"""Verdicts of the ledger, stored with their provenance for the studio, which does not compute the ledger.

python validation/paper/verdicts.py  # compute the ledger and store its verdicts, about 20 s
"""

import json
from pathlib import Path
from typing import Any

from hypertuna.io.files import shipped, write_atomically
from hypertuna.paper.computed import MODELS
from hypertuna.paper.ledger import CLASSES, MARKS
from hypertuna.paper.reproduce import Ledger, reproduce

COMMAND = "python validation/paper/verdicts.py"
FACTS = ("hypertuna_version", "isa", "robot", "robot_hash")  # facts of provenance that are stored with the verdicts


def verdicts_of(ledger: Ledger) -> dict[str, Any]:
    """Return the record of a ledger's verdicts: provenance, meanings of the words, and an entry for each."""
    water = ledger.trials[next(iter(MODELS))].robot.model.water
    entries = [
        {
            "id": entry.id,
            "model": entry.model,
            "class": entry.class_,
            "computed": entry.computed,
            "verdict": entry.verdict,
            "seeds": None if entry.seeds is None else [entry.seeds.passed, entry.seeds.count],
            "band": None if entry.band is None else list(entry.band),
            "note": f"{entry.note}; {entry.why}" if entry.why else entry.note,
        }
        for entry in ledger.entries
    ]
    return {
        **{key: ledger.provenance[key] for key in FACTS},
        "command": COMMAND,
        "marks": MARKS,
        "classes": CLASSES,
        "models": {name: {"water": water} | choice for name, choice in MODELS.items()},  # of a settled beat
        "entries": entries,
    }


def write_verdicts(ledger: Ledger) -> Path:
    """Store the verdicts of a ledger, an entry in each line."""
    record = verdicts_of(ledger)
    lines = ",\n".join(f"  {json.dumps(entry)}" for entry in record.pop("entries"))
    opening = json.dumps(record, indent=1, ensure_ascii=False).removesuffix("\n}")
    content = f'{opening},\n "entries": [\n{lines}\n ]\n}}\n'
    return write_atomically(shipped("data/published") / "verdicts.json", content.encode())


if __name__ == "__main__":
    print(f"stored: {write_verdicts(reproduce())}")
