"""The program `hypertuna`, and `python -m hypertuna`: Ctrl-C ends it quietly while its modules load."""

import os
import signal


def main() -> None:
    """Load the program and run it."""
    usual = signal.getsignal(signal.SIGINT)
    if usual is signal.default_int_handler:  # nohup and the like hold it back
        signal.signal(signal.SIGINT, _leave)
    from hypertuna.cli.main import main as program

    signal.signal(signal.SIGINT, usual)
    program()


def _leave(*_: object) -> None:
    """End the process: nothing is written yet."""
    os.write(2, b"interrupted\n")
    os._exit(130)


if __name__ == "__main__":
    main()
