"""Callbacks: their beginning and end, their calls, their callback groups."""
