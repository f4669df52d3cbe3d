"""Headers of the core include each other one way and stay within the means of a microcontroller."""

import graphlib
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
HEADERS = ROOT / "core" / "include" / "hypertuna"

# The core runs on a microcontroller: no heap, no exceptions, no input or output, nothing of Python. Its folder host/
# owns the memory on a computer.
STANDARD_HEADERS = {
    *("algorithm", "array", "bit", "cmath", "concepts", "cstddef", "cstdint", "initializer_list", "limits"),
    *("string_view", "tuple", "type_traits", "utility"),
}
# Of host/: the heap, and numbers in sentences by `std::snprintf`; <charconv> would add its tables to every page.
HOST_HEADERS = {"cstdio", "cstring", "functional", "memory", "optional", "span", "string", "vector"}


def includes(source: Path) -> list[tuple[str, str]]:
    """Pairs of delimiter and header that a C++ file includes."""
    return re.findall(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', source.read_text(), flags=re.MULTILINE)


def test_headers_of_the_core_include_each_other_one_way() -> None:
    graph = {
        f"hypertuna/{path.relative_to(HEADERS)}": {name for mark, name in includes(path) if mark == '"'}
        for path in HEADERS.rglob("*.hpp")
    }
    order = list(graphlib.TopologicalSorter(graph).static_order())  # raises CycleError naming the cycle
    assert set(order) == set(graph), f"the core includes what is not the core: {sorted(set(order) - set(graph))}"


@pytest.mark.parametrize("header", sorted(HEADERS.rglob("*.hpp")), ids=lambda path: path.name)
def test_header_of_the_core_stays_within_its_means(header: Path) -> None:
    allowed = STANDARD_HEADERS | (HOST_HEADERS if header.parent.name == "host" else set())
    foreign = {name for mark, name in includes(header) if mark == "<"} - allowed
    assert not foreign, f"{header.name} must do without {sorted(foreign)}"
    code = re.sub(r"//[^\n]*", "", header.read_text())
    forbidden = set(re.findall(r"\b(?:new|delete|malloc|throw|try|virtual|printf)\b", re.sub(r"=\s*delete", "", code)))
    assert not forbidden, f"{header.name} must do without {sorted(forbidden)}"
