"""The commands of the finite elements."""
