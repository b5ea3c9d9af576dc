"""Constraints on the times of a system model: each time must belong to an element that can take time."""
