"""Subcommands that ask questions about models."""
