"""`python -m hypertuna` is the program `hypertuna`."""

from hypertuna.cli.main import main

main()
