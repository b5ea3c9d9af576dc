"""Decides from texts of functions which fields of messages and responses are certain."""
