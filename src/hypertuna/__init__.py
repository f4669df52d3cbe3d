"""Open digital twin and control stack for soft robotic fish."""
