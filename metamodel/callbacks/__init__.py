"""Callbacks: where they begin and end, who calls whom, which callback group they are in."""
