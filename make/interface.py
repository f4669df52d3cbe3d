"""Write what the studio knows of the core: `python make/interface.py > studio/interface.ts`.

It is read from `hosts/hypertuna.h`, whose functions are bound or excluded here, and from lists of the core.
"""

import re
import sys
from pathlib import Path

TOP = Path(__file__).resolve().parents[1]
HEADER = (TOP / "hosts/hypertuna.h").read_text(encoding="utf-8")
EXCLUDED = {
    "ht_robot_models": "the text lists them",
    "ht_robot_missions": "the text lists them",
    "ht_twin_jam": "no view lets a fin fail",
    "ht_twin_state_size": "no view goes back in time",
    "ht_twin_save": "no view goes back in time",
    "ht_twin_restore": "no view goes back in time",
}
LISTS = {"FaultKind": "simulation/sensors.hpp", "BeatStatus": "host/beat_status.hpp"}  # of the core, by enumeration
SIZES = {"int": 4, "double": 8, "uint64_t": 8}  # in WebAssembly


def functions() -> dict[str, str]:
    """Return each function of the header as a line of TypeScript."""
    found = {}
    for result, name, given in re.findall(r"HT_API ([\w* ]+?) ?(ht_\w+)\((.*?)\);", HEADER, re.DOTALL):
        names = (re.sub(r"\[\d*\]", "", one).split()[-1].lstrip("*") for one in given.split(","))
        arguments = ", ".join(f"{one}: number" for one in names)
        found[name] = f"{name}({arguments}): {'void' if result == 'void' else 'number'};"
    return found


def layout(struct: str) -> dict[str, int]:
    """Return the place of each field of a struct of the header, and its size [bytes]."""
    (fields,) = re.findall(r"typedef struct \{([^}]*)\} " + struct, HEADER)
    places, end = {}, 0
    for kind, name, count in re.findall(r"^ +(\w+) (\w+)(?:\[(\d+)\])?;", fields, re.MULTILINE):
        places[name] = -(-end // SIZES[kind]) * SIZES[kind]
        end = places[name] + SIZES[kind] * int(count or 1)
    return places | {"size": -(-end // 8) * 8}


def members(kind: str) -> dict[str, int]:
    """Return the members of an enumeration of the core."""
    text = (TOP / "core/include/hypertuna" / LISTS[kind]).read_text(encoding="utf-8")
    (found,) = re.findall(rf"enum class {kind}\b[^{{]*\{{([^}}]*)\}}", text)
    return {name.strip(): k for k, name in enumerate(found.split(","))}


def written() -> str:
    """Return the file."""
    bound = [f"  {line}" for name, line in functions().items() if name not in EXCLUDED]
    tables = {"START": layout("ht_start")} | {kind: members(kind) for kind in LISTS}
    rows = [
        f"export const {name} = {{ {', '.join(f'{key}: {k}' for key, k in table.items())} }} as const;"
        for name, table in tables.items()
    ]
    head = "// Written by make/interface.py from hosts/hypertuna.h and the core's lists."
    start = "/** Places in an ht_start, and its size [bytes]; members of the core's enumerations. */"
    return "\n".join([head, "", "export interface Functions {", *bound, "}", "", start, *rows, ""])


if __name__ == "__main__":
    sys.stdout.write(written())
