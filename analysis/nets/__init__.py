"""Nets of places and transitions as arrays, and what their structure alone tells."""
