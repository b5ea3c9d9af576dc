"""Differences between two models, as one picture."""
