"""Mutants: what is changed, in which order, and that processes import the changed module from unchanged files."""

import ast
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from judge import KILLED, SURVIVED, TIMEOUT, outcome, suite
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


def test_tests_nearest_to_a_mutant_come_first() -> None:
    one = next(m for m in mutants(ROOT, "src/hypertuna/trials/smoothing.py") if m.function == "smooth")
    order, plain = suite("trials", one), suite("trials")
    assert Path(order[0]).name == "test_smoothing.py" != Path(plain[0]).name
    assert sorted(order) == plain
