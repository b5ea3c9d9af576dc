"""Nets without bounds: coverability, by guided search and by the tree of Karp and Miller."""
