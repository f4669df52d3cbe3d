"""Optional packages: the check before they are imported, and the command that installs them."""

import re
from importlib.util import find_spec

from hypertuna.errors import InputError


def need(extra: str, *modules: str, by: str) -> None:
    """Check that modules of an extra are installed; `by` says what needs them."""
    missing = [name for name in modules if find_spec(name) is None]
    if missing:
        raise InputError(f"is needed by {by} and is not installed", key=missing[0], fix=install_command(extra))


def install_command(extra: str) -> str:
    """Return the command that installs the packages of an extra by their names, for a clone and a wheel alike."""
    from importlib import metadata

    try:
        lines = metadata.requires("hypertuna") or []
    except metadata.PackageNotFoundError:  # the package is not installed
        return f"pip install '.[{extra}]' in the folder of the clone"
    of_extra = re.compile(rf"""extra\s*==\s*["']{extra}["']""")
    return " ".join(["pip install", *(f"'{r.partition(';')[0].strip()}'" for r in lines if of_extra.search(r))])
