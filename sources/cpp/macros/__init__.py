"""Macros that the files of a folder define, and the text that they stand for."""
