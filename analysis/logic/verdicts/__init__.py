"""Runs that show an answer to a temporal question."""
