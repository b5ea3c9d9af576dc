"""Subcommands for existing systems."""
