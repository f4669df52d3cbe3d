"""Standard streams and signals of the program: closed or narrow streams, readers that stop, warnings, interrupts."""

import codecs
import contextlib
import os
import signal
import sys
import threading
import unicodedata
import warnings
from types import FrameType
from typing import Any, TextIO

from hypertuna.errors import DamageWarning

INTERRUPTED = 130  # exit code after Ctrl-C; the parser may return it too
# Characters -> replacements for streams that cannot write them.
PLAIN = {"−": "-", "–": "-", "—": "-", "…": "...", "×": "x", "·": " ", "°": "deg", "±": "+-", "≈": "~", "’": "'"}
PLAIN |= {"÷": "/", "µ": "u", "η": "eta", "π": "pi", "→": "->", "≤": "<=", "≥": ">=", "✓": "ok", "✗": "no", "≠": "!="}
IMPORTING, SWALLOWED = 0.02, 1.0  # s until an interrupt is repeated: during an import, and in case a library hid it
# Whether Ctrl-C came, the sentence on the work done until then, and the notes on the command so far.
state: dict[str, Any] = {"interrupted": False, "done": "", "notes": []}


def open_streams() -> None:
    """Open closed standard streams on the null device, and let narrow encodings write other characters plainly."""
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, mode, encoding="utf-8"))  # noqa: SIM115  # open until the program ends
    codecs.register_error("hypertuna-plain", _plainly)
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure") and stream.errors in ("strict", "surrogateescape", "backslashreplace"):
            stream.reconfigure(errors="hypertuna-plain")
    warnings.showwarning = _show_warning


def _plainly(error: UnicodeError) -> tuple[str, int]:
    """Return plain characters, or "?", for those that a stream cannot write, and the index after them."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    text = error.object[error.start : error.end]
    plain = (PLAIN.get(c) or unicodedata.normalize("NFKD", c).encode("ascii", "ignore").decode() or "?" for c in text)
    return "".join(plain), error.end


def _show_warning(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    file: TextIO | None = None,
    line: str | None = None,
) -> None:
    """Print a warning on a file as one sentence, others as Python does."""
    sentence = f"warning: {message}\n"
    if not issubclass(category, DamageWarning):
        sentence = warnings.formatwarning(message, category, filename, lineno, line)
    write_error(sentence, file)


def write_error(text: str, file: TextIO | None = None) -> None:
    """Write a text to the error output, or to `file`; ignore a reader that has gone."""
    with contextlib.suppress(OSError, ValueError):
        (file or sys.stderr).write(text)


def note(sentence: str) -> None:
    """Print a note on input that is accepted but may be a mistake; the JSON record lists it as well."""
    state["notes"].append(sentence)
    write_error(f"note: {sentence}\n")


def end_on_signals() -> None:
    """Let SIGTERM and a closed terminal end the program as Ctrl-C does, unless nohup holds the signal back."""
    state.update(interrupted=False, done="", notes=[])
    if threading.current_thread() is not threading.main_thread():
        return
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) in (signal.SIG_DFL, signal.default_int_handler):
            signal.signal(number, _interrupt)


def _interrupt(_: int, frame: FrameType | None) -> None:
    """Record the interrupt, which a library may swallow, and raise it after imports."""
    state["interrupted"] = True
    sys.unraisablehook = lambda _: None  # hides the interrupt in a library's callback; it is repeated
    while frame is not None and frame.f_code.co_filename != "<frozen importlib._bootstrap>":
        frame = frame.f_back
    if hasattr(signal, "setitimer"):  # a cut import leaves half a module; a library may hide the exception
        signal.signal(signal.SIGALRM, _interrupt)
        signal.setitimer(signal.ITIMER_REAL, SWALLOWED if frame is None else IMPORTING)
    if frame is None or not hasattr(signal, "setitimer"):
        raise KeyboardInterrupt


def was_interrupted() -> bool:
    """Return whether an interrupt has occurred, and stop its repetition."""
    if state["interrupted"] and hasattr(signal, "setitimer"):
        signal.setitimer(signal.ITIMER_REAL, 0)
    return bool(state["interrupted"])


def drop_unwritable_output() -> None:
    """Close an output that cannot be written, so that Python does not complain at exit."""
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:
            with contextlib.suppress(OSError):
                stream.close()
