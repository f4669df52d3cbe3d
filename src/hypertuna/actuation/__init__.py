"""Silicone, soft joint, bending, hydraulics, sizing, battery."""
