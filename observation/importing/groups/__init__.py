"""Callback groups of imported nodes, and executors that several nodes share."""
