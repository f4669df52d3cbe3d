"""How tests call the program: the type of the fixture `run` of conftest.py."""

from collections.abc import Callable

Run = Callable[..., tuple[int, str, str]]  # arguments: exit code, output, errors
