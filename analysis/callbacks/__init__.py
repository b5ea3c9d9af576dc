"""Callbacks of nodes that are written by hand: which of them wait for each other, and what fixes it."""
