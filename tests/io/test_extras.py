"""What a command says where an optional package is missing."""

import re
import tomllib
from importlib.metadata import PackageNotFoundError
from pathlib import Path

import pytest

import hypertuna as ht
from hypertuna.io import extras

ROOT = Path(__file__).parents[2]
EXTRAS = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]


@pytest.mark.parametrize("extra", ["fe", "log", "radio"])
def test_the_command_names_the_packages_of_the_extra(extra: str, monkeypatch: pytest.MonkeyPatch) -> None:
    lines = [f'{package}; extra == "{name}"' for name, packages in EXTRAS.items() for package in packages]
    monkeypatch.setattr("importlib.metadata.requires", lambda name: ["numpy>=2.0", *lines])
    assert extras.install_command(extra) == "pip install " + " ".join(f"'{package}'" for package in EXTRAS[extra])


def test_without_metadata_the_command_is_that_of_a_clone(monkeypatch: pytest.MonkeyPatch) -> None:
    def unknown(name: str) -> None:
        raise PackageNotFoundError(name)

    monkeypatch.setattr("importlib.metadata.requires", unknown)
    assert extras.install_command("fe") == "pip install '.[fe]' in the folder of the clone"


def test_the_first_missing_module_is_named() -> None:
    with pytest.raises(ht.InputError, match=r"^no_such_module is needed by logs and is not installed: pip install '"):
        extras.need("log", "sys", "no_such_module", by="logs")


def test_nothing_says_that_hypertuna_is_on_the_package_index() -> None:
    folders = ("src", "docs", "examples", "firmware", "README.md", "CONTRIBUTING.md", "Makefile")
    files = [file for name in folders for file in [ROOT / name, *(ROOT / name).rglob("*")] if file.is_file()]
    texts = {file: file.read_bytes() for file in files if "_build" not in file.parts}
    assert not [file for file, text in texts.items() if re.search(rb"pip install (-U )?['\"]?hypertuna\b", text)]
