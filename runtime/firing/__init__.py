"""Firings: which transition fires, which handlers run, and how results and failures are handled."""
