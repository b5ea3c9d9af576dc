"""Runs the scripts of the pages outside of a browser: in V8, in a separate process.

If that process fails, the command continues: `evaluate` raises, and the result has no picture.
"""
