"""Firings: what is selected, which handlers are called, what becomes of results and failures."""
