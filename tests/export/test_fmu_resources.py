"""FMUs whose resources were changed: importers get no instance and a sentence, and never end."""

from __future__ import annotations

import os
import re
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import pytest

import hypertuna as ht
from fmu_unit import Unit


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[int, Path]:
    """FMUs of HyperTuna in the plane, by version of the standard."""
    made = {fmi: tmp_path_factory.mktemp("fmus") / f"twin{fmi}.fmu" for fmi in (2, 3)}
    for fmi, path in made.items():
        path.write_bytes(ht.fmu("hypertuna", fmi=fmi))
    return made


def changed(path: Path, to: Path, **contents: Any) -> Path:
    """Write an FMU with other resources."""
    with ZipFile(path) as archive, ZipFile(to, "w") as out:
        for name in archive.namelist():
            content = archive.read(name)
            change = contents.get(Path(name).stem)
            out.writestr(name, change(content) if change else content)
    return to


WRONG: dict[str, tuple[Any, str]] = {
    "image": ({"robot": lambda content: content[:-8]}, "image"),
    "no line": ({"variables": lambda content: content[:200] + b"?\n"}, "line [0-9]+: cannot be read"),
    "column": ({"variables": lambda content: content.replace(b" surge", b" urge")}, "robot has no such output"),
    "place of an output": ({"variables": lambda content: content.replace(b"surge 0", b"surge 1")}, "no such output"),
    "place of an input": ({"variables": lambda content: content.replace(b"input 0", b"input 13")}, "no such input"),
    "far input": ({"variables": lambda content: content.replace(b"input 0", b"input 99999999")}, "no such input"),
    "input before": (
        {"variables": lambda content: content.replace(b"input 0", b"input -9999")},
        "line 3: cannot be read",
    ),
    "parameter": ({"variables": lambda content: content.replace(b"fixed 0", b"fixed 99999")}, "line [0-9]+: cannot"),
    "parameter before": (
        {"variables": lambda content: content.replace(b"fixed 0", b"fixed -1")},
        "line [0-9]+: cannot",
    ),
    "role": ({"variables": lambda content: content.replace(b"fixed 0", b"foxed 0")}, "line [0-9]+: cannot be read"),
    "start": ({"variables": lambda content: content.replace(b"fixed 0 0", b"fixed 0 nan")}, "cannot be read"),
    "seed": ({"variables": lambda content: content.replace(b"fixed 0 0", b"fixed 0 -1")}, "seed: must be from 0"),
    "empty": ({"variables": lambda _: b""}, "line 1: cannot be read"),
    "large": ({"variables": lambda content: content * 2000}, "variables must be a readable file of at most 1048576"),
    "large image": ({"robot": lambda content: content * 400}, "robot.image must be a readable file of at most"),
}


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("name", WRONG)
def test_wrong_resources_are_refused(files: dict[int, Path], name: str, fmi: int, tmp_path: Path) -> None:
    """By no instance and a sentence, in a process of its own: importers must not end."""
    contents, sentence = WRONG[name]
    file = changed(files[fmi], tmp_path / "wrong.fmu", **contents)
    with ZipFile(file) as archive, ZipFile(files[fmi]) as whole:
        assert any(archive.read(one) != whole.read(one) for one in whole.namelist())
    code, said = in_child(lambda: refused(file))
    assert code == 0, said
    assert re.search(sentence, said), said


def test_a_token_of_another_is_refused(files: dict[int, Path]) -> None:
    assert re.search("token: is of another FMU", refused(files[2], token="another"))


def test_a_seed_that_is_none_leaves_the_instance_as_it_was(files: dict[int, Path]) -> None:
    unit = Unit(files[2])
    unit.unit.reset()
    with pytest.raises(Exception, match="etInteger"):
        unit.set(seed=-1)
    assert unit.said.pop() == "seed: must be from 0 to 2^53, but is -1"
    unit.set(start_speed=0.1)
    unit.close()


def refused(file: Path, token: str | None = None) -> str:
    """Return what is said of an FMU that is refused."""
    said = list[str]()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Unit, "said", said, raising=False)
        patch.setattr(Unit, "_log", lambda self, *args: said.append(args[-1].decode()))
        patch.setattr(Unit, "_log3", lambda self, *args: said.append(args[-1].decode()))
        with pytest.raises(Exception, match="nstantiate"):
            Unit(file, token=token)
    return " ".join(said)


def in_child(work: Callable[[], str]) -> tuple[int, str]:
    """Run in a forked process; return how it ended, and what it returns or raises."""
    begin, end = os.pipe()
    with warnings.catch_warnings(action="ignore"):  # of threads that the child does not need
        child = os.fork()
    if not child:
        try:
            text, code = work(), 0
        except BaseException as error:
            text, code = f"{type(error).__name__}: {error}", 1
        os.write(end, text.encode()[:4000])
        os._exit(code)
    os.close(end)
    with os.fdopen(begin) as answer:
        text = answer.read()
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), text
