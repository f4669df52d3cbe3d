"""Mutants: what is changed, in which order, and that processes import the changed module from unchanged files."""

import ast
import json
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest
from judge import BUDGET, FIRST, KILLED, SURVIVED, TIMEOUT, Trace, chosen, modules, outcome, rooms
from mutants import Mutant, drawn, mutants, mutated

ROOT = Path(__file__).parents[1]
SOURCE = '''"""A module."""
LIMIT: int = 3


def small(x: float, open: bool = True) -> bool:
    """Return whether 2 < 3."""
    if not open:
        raise ValueError(f"must be at most {LIMIT + 1}")
    return -x < LIMIT
'''


@pytest.fixture
def module(tmp_path: Path) -> Path:
    (tmp_path / "small.py").write_text(SOURCE)
    return tmp_path


def test_operators_and_numbers_change_but_no_message_and_no_annotation(module: Path) -> None:
    found = {one.name.removeprefix("small.py: ") for one in mutants(module, "small.py")}
    assert found == {
        ": LIMIT: int = 3 -> LIMIT: int = 4",
        "small: def small(x: float, open: bool=True) -> bool: -> def small(x: float, open: bool=False) -> bool:",
        "small: if not open: -> if open:",
        "small: return -x < LIMIT -> return x < LIMIT",
        "small: return -x < LIMIT -> return -x <= LIMIT",
    }


def test_a_seed_orders_mutants_by_what_they_are(module: Path) -> None:
    order = [one.name for one in drawn(module, ["small.py"], 1)]
    assert order != [one.name for one in drawn(module, ["small.py"], 2)]
    (module / "small.py").write_text("import math\n\n\n" + SOURCE)  # mutants elsewhere keep their names
    assert {one.name for one in drawn(module, ["small.py"], 1)} == set(order)


def test_a_mutant_changes_one_place_of_a_copy(module: Path) -> None:
    tree = ast.parse(SOURCE)
    (one,) = (mutant for mutant in mutants(module, "small.py") if "<=" in mutant.after)
    assert ast.unparse(mutated(tree, one.place)) == ast.unparse(tree).replace("-x < LIMIT", "-x <= LIMIT")
    assert ast.unparse(tree) == ast.unparse(ast.parse(SOURCE))


def of(module: str, after: str) -> Mutant:
    (one,) = (m for m in mutants(ROOT, f"src/hypertuna/{module}.py") if m.after == after)
    return one


def test_every_process_imports_the_mutant(tmp_path: Path) -> None:
    one, seen = of("ranges", "NOT_NEGATIVE = Range(min=1)"), tmp_path / "imported"
    told = {"name": "hypertuna.ranges", "file": str(ROOT / one.module), "place": one.place, "imported": str(seen)}
    code = "from hypertuna.ranges import NOT_NEGATIVE; print(NOT_NEGATIVE.min)"
    for mutant, expected in ((None, "0"), (told, "1")):
        environment = os.environ | {"PYTHONPATH": str(ROOT / "validation/mutants/path")}
        environment["HYPERTUNA_MUTANT"] = json.dumps(mutant)
        run = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
        assert run.stdout.strip() == expected
        assert seen.exists() == (mutant is not None)


def test_a_mutant_is_killed_by_a_test_that_imports_it_and_fails(tmp_path: Path) -> None:
    one, file = of("ranges", "NOT_NEGATIVE = Range(min=1)"), tmp_path / "test_ranges.py"
    use, check = "from hypertuna.ranges import NOT_NEGATIVE", "assert NOT_NEGATIVE.min == 0"
    for body, expected in ((f"{use}; {check}", KILLED), (use, SURVIVED), ("pass", SURVIVED)):
        file.write_text(f"def test_it():\n    {body}\n")
        assert outcome([str(file)], one) == expected
    file.write_text("def test_it():\n    raise ValueError\n")  # no test imported the mutant
    for mutant in (None, one):
        with pytest.raises(SystemExit, match="tests must pass without a mutant"):
            outcome([str(file)], mutant)
    file.write_text(f"import time\n\n\ndef test_it():\n    {use}\n    time.sleep(60)\n")
    assert outcome([str(file)], one, limit=2) == TIMEOUT


def test_a_mutant_has_the_lines_of_its_statement(module: Path) -> None:
    lines = {one.name.removeprefix("small.py: "): one.lines for one in mutants(module, "small.py")}
    assert lines == {
        ": LIMIT: int = 3 -> LIMIT: int = 4": None,  # at import
        "small: def small(x: float, open: bool=True) -> bool: -> def small(x: float, open: bool=False) -> bool:": (
            6,
            9,
        ),
        "small: if not open: -> if open:": (7, 7),
        "small: return -x < LIMIT -> return x < LIMIT": (9, 9),
        "small: return -x < LIMIT -> return -x <= LIMIT": (9, 9),
    }


def test_those_that_execute_a_mutant_judge_it_the_fastest_first(module: Path) -> None:
    at_import, _, branch, *_ = mutants(module, "small.py")
    assert (at_import.lines, branch.lines) == (None, (7, 7))
    tests = {
        "": Trace(lines={"small.py": {2}}),
        "a.py": Trace(lines={"other.py": {7}}),
        "a.py::slow": Trace(2.0, {"small.py": {7, 9}}),
        "a.py::fast": Trace(1.0, {"small.py": {7}}),
        "a.py::same_file": Trace(0.1, {"small.py": {9}}),
        "b.py::other": Trace(0.1, {"other.py": {7}}),
    }
    assert chosen(tests, branch) == [["a.py::fast", "a.py::slow"], ["a.py::same_file"]]
    assert chosen(tests, at_import) == [["a.py::same_file", "a.py::fast", "a.py::slow"], ["b.py::other"]]
    assert chosen({"b.py::other": tests["b.py::other"]}, branch) == []  # survives at once
    many = {f"a.py::{k}": Trace(k / FIRST, {"small.py": {7}}) for k in range(FIRST + 1)}
    assert [len(group) for group in chosen(many, branch)] == [FIRST, 1]


def test_the_tests_of_a_mutant_have_a_budget_and_share_their_fixtures(module: Path) -> None:
    _, _, branch, *_ = mutants(module, "small.py")
    names = {"a.py::1": 0.1, "b.py::1": 0.2, "a.py::2": 0.3, "b.py::2": BUDGET - 0.5, "b.py::3": BUDGET}
    tests = {name: Trace(seconds, {"small.py": {7}}) for name, seconds in names.items()}
    assert chosen(tests, branch) == [["a.py::1", "a.py::2", "b.py::1"]]  # with b.py::2, 0.1 s over the budget
    assert chosen({"b.py::3": Trace(2 * BUDGET, {"small.py": {7}})}, branch) == [["b.py::3"]]  # one always


def test_a_run_leaves_nothing_to_the_next(tmp_path: Path) -> None:
    """Of a mutant, of a module that a test changes, and of a process that a test leaves behind."""
    one, file = of("ranges", "NOT_NEGATIVE = Range(min=1)"), tmp_path / "test_ranges.py"
    file.write_text(
        "import math, subprocess\n\n\ndef test_it():\n    from hypertuna.ranges import NOT_NEGATIVE\n"
        "    assert NOT_NEGATIVE.min == 0\n    assert math.pi > 3\n    math.pi = 3\n"
        f"    open({str(tmp_path / 'pid')!r}, 'w').write(str(subprocess.Popen(['sleep', '600']).pid))\n"
    )
    assert [outcome([str(file)], mutant) for mutant in (one, None, None)] == [KILLED, SURVIVED, SURVIVED]
    state, end = Path(f"/proc/{(tmp_path / 'pid').read_text()}/stat"), time.monotonic() + 30
    while state.exists() and state.read_text().rpartition(")")[2].split()[0] != "Z":
        assert time.monotonic() < end
        time.sleep(0.1)


def test_lines_of_a_test_are_those_of_its_process_and_of_those_that_it_starts(tmp_path: Path) -> None:
    file = tmp_path / "test_ranges.py"
    here = "from hypertuna.ranges import POSITIVE; POSITIVE.check(1.0, 'speed')"
    there = f"import subprocess, sys; subprocess.run([sys.executable, '-c', {here!r}], check=True)"
    forked = "from multiprocessing import get_context as c; p = c('fork').Process(target=there); p.start(); p.join()"
    file.write_text(
        f"def there():\n    {here}\n\n\ndef test_none():\n    pass\n\n\ndef test_here():\n    {here}\n\n\n"
        f"def test_there():\n    {there}\n\n\ndef test_forked():\n    {forked}\n"
    )
    lines = tmp_path / "lines"
    lines.mkdir()
    assert outcome([str(file)], lines=str(lines)) == SURVIVED
    rows = [json.loads(row) for part in lines.iterdir() for row in part.read_text().splitlines()]
    found = {row["test"].partition("::")[2] for row in rows if "::" in row["test"] and "ranges.py" in row["lines"]}
    assert found == {"test_here", "test_there", "test_forked"}


def test_every_module_is_of_one_room() -> None:
    """Rooms with tests of their own, and what they leave."""
    of_rooms = [module for room in rooms() for module in modules(room)]
    assert len(of_rooms) == len(set(of_rooms))
    left = {str(path.relative_to(ROOT)) for path in (ROOT / "src/hypertuna").rglob("*.py")} - set(of_rooms)
    assert {Path(path).stem for path in left} <= {"__init__", "__main__", "arrays", "errors", "figures", "pictures"}
