"""Symbolic engine: complete state spaces as decision diagrams."""
