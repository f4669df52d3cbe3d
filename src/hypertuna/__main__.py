"""`python -m hypertuna` is the program `hypertuna`."""

from hypertuna.cli import main

main()
