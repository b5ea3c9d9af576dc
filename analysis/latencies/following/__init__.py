"""Follows one message or run through a net: each kind of part has its markers."""
