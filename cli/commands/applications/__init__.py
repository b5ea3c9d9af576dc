"""Subcommands that generate and run applications, and look at what they did."""
