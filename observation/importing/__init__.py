"""Imports an observed system as a system model with open behaviour."""
