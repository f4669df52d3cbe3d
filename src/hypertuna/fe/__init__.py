"""The soft joints by finite elements."""
