"""Subcommands that generate and run applications, and evaluate their runs."""
