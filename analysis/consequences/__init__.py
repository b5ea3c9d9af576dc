"""Findings that hold only because of another one: decided by asking again where that one is mended."""
