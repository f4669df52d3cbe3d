"""Chapters of the ledger; `hypertuna.paper.reproduce.CHAPTERS` lists them in the order of the page."""
