"""A surface of `fe bend` without finite elements, and damage that knows its structure."""

import random
import re
from typing import Any

import numpy as np

from hypertuna.fe.fields import DISPLACEMENT, FACE, STRAIN, STRESS
from mutations.damage import of_bytes, of_text

TYPES = {"<f8": "Float64", "<i4": "Int32", "|u1": "UInt8"}
SIZES = (0, 1, 2, 1000, 10**8, 2**31 - 1, 2**31, 2**32 - 1)


def surface() -> bytes:
    """Return a surface of triangles and quadrilaterals, as NGSolve writes it."""
    sizes = np.array([4, 4, 3] * 6)
    count, corners = len(sizes), int(sizes.sum())
    points = np.random.default_rng(1).uniform(-0.02, 0.02, (corners, 3))
    parts = {"Points": points, "connectivity": np.arange(corners, dtype="<i4")}
    parts |= {"offsets": np.cumsum(sizes).astype("<i4"), "types": np.where(sizes == 4, 9, 5).astype(np.uint8)}
    parts |= {DISPLACEMENT: 0.1 * points, STRESS: np.abs(points[:, 0]), STRAIN: points[:, 1]}
    return written(parts | {FACE: np.repeat(np.arange(count) % 6.0, sizes)})


def written(parts: dict[str, Any]) -> bytes:
    """Return a surface of these arrays."""
    corners, count = len(parts["Points"]), len(parts["types"])
    lines, numbers = list[str](), b""
    for name, values in parts.items():
        width = "" if name in ("connectivity", "offsets", "types") else f' NumberOfComponents="{values[0].size}"'
        about = f'type="{TYPES[values.dtype.str]}" Name="{name}"{width} format="appended" offset="{len(numbers)}"'
        lines.append(f"<DataArray {about}>\n\n</DataArray>\n")
        numbers += len(values.tobytes()).to_bytes(4, "little") + values.tobytes()
    head = '<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian">\n'
    head += f'<UnstructuredGrid>\n<Piece NumberOfPoints="{corners}" NumberOfCells="{count}">\n<Points>\n{lines[0]}'
    head += f"</Points>\n<Cells>\n{''.join(lines[1:4])}</Cells>\n<PointData>\n{''.join(lines[4:])}</PointData>\n"
    head += '</Piece>\n</UnstructuredGrid>\n<AppendedData encoding="raw">\n_'
    return head.encode() + numbers + b"\n</AppendedData>\n</VTKFile>\n"


def of_surface(content: bytes, chance: random.Random) -> bytes:
    """Damage a surface: sizes that lie, corners that are not there, another head."""
    begin = content.index(b"\n_") + 2
    head, numbers = content[:begin], bytearray(content[begin:])
    places = [int(one) for one in re.findall(rb'offset="(\d+)"', head)]
    kind = chance.randrange(4)
    if kind == 0:  # the length of an array
        at = chance.choice(places)
        numbers[at : at + 4] = chance.choice(SIZES).to_bytes(4, "little")
    elif kind == 1:  # a number of one: points, corners, ends, types, fields
        at = chance.choice(places) + 4 + 4 * chance.randrange(20)
        numbers[at : at + 4] = chance.choice((b"\xff" * 4, bytes(4), chance.randbytes(4)))
    elif kind == 2:
        head = of_text(head, chance)
    else:
        return of_bytes(content, chance)
    return head + bytes(numbers)
