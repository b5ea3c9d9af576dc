"""Interprets modules of Python's standard library that call functions which they are given."""
