"""Write the studio's part of the core's interface: `python make/interface.py > studio/interface.ts`.

It is made from `hosts/hypertuna.h`, whose functions are bound or excluded here, and from lists of the core.
"""

import re
import sys
from pathlib import Path
from typing import Any

TOP = Path(__file__).resolve().parents[1]
HEADER = (TOP / "hosts/hypertuna.h").read_text(encoding="utf-8")
# Functions that the studio does not call, with the reason.
EXCLUDED = {
    "ht_robot_models": "the text lists them",
    "ht_robot_missions": "the text lists them",
    "ht_twin_jam": "no view lets a fin fail",
    "ht_twin_state_size": "no view goes back in time",
    "ht_twin_save": "no view goes back in time",
    "ht_twin_restore": "no view goes back in time",
}
CORE = TOP / "core/include/hypertuna"  # folder of the core's headers
LISTS = {
    "FaultKind": "simulation/sensors.hpp",
    "BeatStatus": "host/beat_status.hpp",
    "Better": "swimming/quantities.hpp",
}  # enumeration -> header that declares it
NUMBERS = {"beat_steps": "host/beat_status.hpp", "nearly_straight": "swimming/quantities.hpp"}  # number -> its header
SIZES = {"char": 1, "int": 4, "uint32_t": 4, "double": 8, "uint64_t": 8}  # bytes of a type in WebAssembly


def functions() -> dict[str, str]:
    """Return each function of the header as a line of TypeScript."""
    found = {}
    for result, name, given in re.findall(r"HT_API ([\w* ]+?) ?(ht_\w+)\((.*?)\);", HEADER, re.DOTALL):
        names = (re.sub(r"\[\d*\]", "", one).split()[-1].lstrip("*") for one in given.split(","))
        arguments = ", ".join(f"{one}: number" for one in names)
        found[name] = f"{name}({arguments}): {'void' if result == 'void' else 'number'};"
    return found


def layout(struct: str) -> dict[str, int]:
    """Return the offset of each field of a struct of hosts/, and the size of the struct [bytes]."""
    text = HEADER + (TOP / "hosts/image.hpp").read_text(encoding="utf-8")
    (fields,) = re.findall(rf"struct {struct} \{{([^}}]*)\}}", text)
    places, end = {}, 0
    for kind, names in re.findall(r"^ +(?:std::)?(\w+) ([\w\[\], ]+);", fields, re.MULTILINE):
        for name, count in re.findall(r"(\w+)(?:\[(\d+)\])?(?:, |$)", names):
            places[name] = -(-end // SIZES[kind]) * SIZES[kind]
            end = places[name] + SIZES[kind] * int(count or 1)
    return places | {"size": -(-end // 8) * 8}


def members(kind: str) -> dict[str, int]:
    """Return the members of an enumeration of the core, by name, with their numbers."""
    (found,) = re.findall(rf"enum class {kind}\b[^{{]*\{{([^}}]*)\}}", (CORE / LISTS[kind]).read_text(encoding="utf-8"))
    names = [name.strip() for name in found.split(",")]
    return {name: k for k, name in enumerate(names) if name != "count"}


def numbers() -> dict[str, float]:
    """Return numbers of the core by name."""
    texts = {name: (CORE / place).read_text(encoding="utf-8") for name, place in NUMBERS.items()}
    return {name: float(re.findall(rf"\b{name} = ([\d.e]+)", text)[0]) for name, text in texts.items()}


def written() -> str:
    """Return the text of studio/interface.ts."""
    bound = [f"  {line}" for name, line in functions().items() if name not in EXCLUDED]
    tables: dict[str, dict[str, Any]] = {"START": layout("ht_start"), "IMAGE": layout("ImageHeader"), "CORE": numbers()}
    tables |= {kind: members(kind) for kind in LISTS}
    rows = [
        f"export const {name} = {{ {', '.join(f'{key}: {k:g}' for key, k in table.items())} }};"
        for name, table in tables.items()
    ]
    head = "// Written by make/interface.py from hosts/hypertuna.h and the core's lists."
    start = "/** Places in structs, and their sizes [bytes]; numbers of the core; members of its enumerations. */"
    return "\n".join([head, "", "export interface Functions {", *bound, "}", "", start, *rows, ""])


if __name__ == "__main__":
    sys.stdout.write(written())
