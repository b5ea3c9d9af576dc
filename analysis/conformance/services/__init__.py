"""Calls of services in a run: which step each has come to, and whose they are."""
