"""Make C headers or a Python module of a MAVLink dialect: `generate.py DIALECT.xml FOLDER LANGUAGE OUTPUT`.

FOLDER has the dialects that it includes. mavgen looks for them beside it, so both go into one folder that goes again.
"""

import contextlib
import io
import shutil
import sys
import tempfile
from pathlib import Path

from pymavlink.generator import mavgen, mavparse


def main(dialect: str, folder: str, language: str, output: str) -> None:
    """Run mavgen; what it prints is told only if it fails."""
    with tempfile.TemporaryDirectory() as place:
        for included in ("common.xml", "standard.xml", "minimal.xml"):
            shutil.copy(Path(folder) / included, place)
        source = Path(shutil.copy(dialect, place))
        options = mavgen.Opts(output, mavparse.PROTOCOL_2_0, language=language, validate=True)
        told = io.StringIO()
        with contextlib.redirect_stdout(told):
            good = mavgen.mavgen(options, [str(source)])
    if not good:
        sys.exit(told.getvalue())


if __name__ == "__main__":
    main(*sys.argv[1:])
