"""Threads that search through state classes together."""
