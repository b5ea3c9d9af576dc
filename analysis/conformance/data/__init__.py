"""Conformance of data: guards and assignments are checked on recorded tokens."""
