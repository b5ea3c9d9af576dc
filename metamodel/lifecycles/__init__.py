"""Managed nodes: their states, and the order in which they start."""
