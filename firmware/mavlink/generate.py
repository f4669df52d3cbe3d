"""Make C headers or a Python module of a MAVLink dialect: `generate.py DIALECT.xml C|Python3 OUTPUT`."""

import contextlib
import io
import shutil
import sys
import tempfile
import warnings
from pathlib import Path

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import pymavlink.dialects.v20
    from pymavlink.generator import mavgen, mavparse

INCLUDED = ("common.xml", "standard.xml", "minimal.xml")


def generate(dialect: str | Path, language: str, output: str | Path) -> None:
    """Run mavgen on a dialect that includes common.xml; what it prints is told only if it fails.

    Parameters
    ----------
    dialect : str or Path
        Its XML file.
    language : {"C", "Python3"}
    output : str or Path
        Folder of headers, or file of a module.

    Raises
    ------
    RuntimeError
        If mavgen fails.
    """
    with tempfile.TemporaryDirectory() as place:
        for name in INCLUDED:  # mavgen looks for them beside the dialect
            shutil.copy(Path(pymavlink.dialects.v20.__path__[0]) / name, place)
        source = shutil.copy(dialect, place)
        options = mavgen.Opts(str(output), mavparse.PROTOCOL_2_0, language=language, validate=True)
        told = io.StringIO()
        with contextlib.redirect_stdout(told):
            good = mavgen.mavgen(options, [source])
    if not good:
        raise RuntimeError(told.getvalue())


if __name__ == "__main__":
    generate(*sys.argv[1:])
