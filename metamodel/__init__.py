"""Metamodels, their typed API, model files and constraints."""
