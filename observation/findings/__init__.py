"""Faults of an observed system that are visible without a model of its behaviour."""
