"""Subcommands that read, change, draw and convert models."""
