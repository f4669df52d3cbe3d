"""Variables of the shell that libraries read as they are imported: checked or hidden, before any import."""

import contextlib
import os
import re

from hypertuna.errors import InputError, shown

# Styles of figures, which may be a stranger's: figures have their own. A switch that NumPy no longer has.
HIDDEN = ("MATPLOTLIBRC", "MPLBACKEND", "NPY_PROMOTION_STATE")
# Whole numbers -> their largest value: s from 1970 to the end of the year 9999, the last that a date can have.
NUMBERS = {"SOURCE_DATE_EPOCH": 253_402_300_799, "NUMPY_MADVISE_HUGEPAGE": 1}


def check_environment() -> None:
    """Check numbers that libraries read, and hide other variables and the style of the present folder from them."""
    for name in HIDDEN:
        os.environ.pop(name, None)
    for name, largest in NUMBERS.items():
        text = os.environ.get(name, "")
        if not text:
            os.environ.pop(name, None)
        elif not re.fullmatch("[0-9]{1,12}", text) or int(text) > largest:
            rule, fix = f"must be a whole number from 0 to {largest}", f"correct the variable, or unset {name}"
            raise InputError(rule, key=name, value=shown(text), fix=fix)
    if os.path.lexists("matplotlibrc"):
        with contextlib.chdir(os.path.dirname(__file__)):  # the file of the present folder is read at the import
            import matplotlib  # noqa: F401
