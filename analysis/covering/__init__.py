"""Nets without bounds: what can be covered, shown by guided search and proved by Karp and Miller's tree."""
