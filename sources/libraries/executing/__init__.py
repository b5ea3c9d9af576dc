"""Executors, the nodes that they run, and threads."""
