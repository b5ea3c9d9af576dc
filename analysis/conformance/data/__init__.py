"""Conformance of data: what guards and assignments say of recorded tokens."""
