"""The command `hypertuna version`."""

import json
import platform

from hypertuna import _core
from hypertuna.cli.options import AsJson
from hypertuna.io.files import version


def version_command(as_json: AsJson = False) -> None:
    """Print the version and the instruction set in use; HYPERTUNA_ISA chooses another."""
    facts = {"version": version(), "isa": _core.isa(), "isas": _core.isas(), "gaits_at_once": _core.lanes()}
    facts |= {"python": platform.python_version(), "machine": platform.machine()}
    if as_json:
        print(json.dumps(facts, indent=2))
        return
    print(f"hypertuna {facts['version']}, Python {facts['python']} on {facts['machine']}")
    print(f"instruction set {_core.isa()} ({_core.lanes()} gaits at once); available: {', '.join(_core.isas())}")
