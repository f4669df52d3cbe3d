"""Import one module mutated: Python runs this file first where this folder is on PYTHONPATH; no file is changed."""

import ast
import importlib.abc
import importlib.util
import json
import os
import sys
from collections.abc import Sequence
from importlib.machinery import ModuleSpec, SourceFileLoader
from pathlib import Path
from types import CodeType, ModuleType

CORE = os.environ.get("HYPERTUNA_CORE")  # file of the built extension
MUTANT = json.loads(os.environ.get("HYPERTUNA_MUTANT", "null"))


class Mutated(SourceFileLoader):
    """Loader that compiles the mutated source, and uses no bytecode of earlier ones."""

    def get_code(self, fullname: str) -> CodeType:
        """Return the mutated module's code."""
        sys.path.insert(0, str(Path(__file__).parents[1]))
        from mutants import mutated

        sys.path.pop(0)
        Path(MUTANT["imported"]).touch()
        tree = ast.parse(Path(self.path).read_text(encoding="utf-8"))
        place = tuple((field, index) for field, index in MUTANT["place"])
        return compile(mutated(tree, place), self.path, "exec")


class Finder(importlib.abc.MetaPathFinder):
    """Finder of the mutated module, asked before all others."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Find the mutated module by its name, and the extension as it is, without a build."""
        if fullname == "hypertuna._core" and CORE:
            return importlib.util.spec_from_file_location(fullname, CORE)
        if MUTANT is None or fullname != MUTANT["name"]:
            return None
        return importlib.util.spec_from_file_location(
            fullname, MUTANT["file"], loader=Mutated(fullname, MUTANT["file"])
        )


sys.meta_path.insert(0, Finder())

if "HYPERTUNA_LINES" in os.environ and "PYTEST_CURRENT_TEST" in os.environ:  # a test started this process
    import lines_by_test as lines_by_test
