"""Compares a model with an observed system: missing, additional and different nodes, ports and channels."""
