"""Interprets calls of single libraries: of parameters, and of loaders of plugins."""
