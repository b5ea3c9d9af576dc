"""Constraints about the data of tokens."""
