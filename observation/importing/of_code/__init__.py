"""Converts the facts of one node of code: its names, its ports, and its behaviour."""
