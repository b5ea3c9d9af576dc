"""Constraints on actions: their servers and their clients."""
