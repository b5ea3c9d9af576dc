"""Walks through a net: markings that are surely reachable, found without storing any."""
