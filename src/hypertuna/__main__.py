"""The program `hypertuna` and `python -m hypertuna`, which Ctrl-C ends without a traceback while modules load."""

import os
import signal

INTERRUPTED = 130  # exit status after Ctrl-C


def main() -> None:
    """Load the program and run it."""
    usual = signal.getsignal(signal.SIGINT)
    if usual is signal.default_int_handler:  # not if the signal is ignored, as under nohup
        signal.signal(signal.SIGINT, _leave)
    from hypertuna.cli.main import main as program

    signal.signal(signal.SIGINT, usual)
    try:
        program()
    except SystemExit as end:
        if end.code == INTERRUPTED:
            os._exit(INTERRUPTED)  # everything is written; the core's threads would run for seconds more
        raise


def _leave(*_: object) -> None:
    """End the process at once, as no file has been written yet."""
    os.write(2, b"interrupted\n")
    os._exit(INTERRUPTED)


if __name__ == "__main__":
    main()
