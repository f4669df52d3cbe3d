"""The program `hypertuna`, and `python -m hypertuna`: Ctrl-C ends it quietly while its modules load."""

import os
import signal

INTERRUPTED = 130  # exit code after Ctrl-C


def main() -> None:
    """Load the program and run it."""
    usual = signal.getsignal(signal.SIGINT)
    if usual is signal.default_int_handler:  # not so under nohup, which ignores the signal
        signal.signal(signal.SIGINT, _leave)
    from hypertuna.cli.main import main as program

    signal.signal(signal.SIGINT, usual)
    try:
        program()
    except SystemExit as end:
        if end.code == INTERRUPTED:
            os._exit(INTERRUPTED)  # all output is written; threads of the core would run on for seconds
        raise


def _leave(*_: object) -> None:
    """End the process at once: it has written nothing yet."""
    os.write(2, b"interrupted\n")
    os._exit(INTERRUPTED)


if __name__ == "__main__":
    main()
