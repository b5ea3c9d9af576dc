"""Reads launch files: the nodes that they start, with names and parameters."""
