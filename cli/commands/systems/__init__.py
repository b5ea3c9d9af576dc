"""Subcommands about systems that exist already."""
