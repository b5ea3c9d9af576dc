"""Managed nodes: their states, and in which order they come up."""
