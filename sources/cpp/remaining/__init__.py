"""Finds what remains after a program has been followed: methods that others call, code that is missing."""
