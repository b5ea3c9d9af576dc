"""Queries of rules about callbacks, times and the arcs around places."""
