"""The pages' own scripts, run outside of a browser: in V8, in a process of its own.

Whatever happens to that process, a command continues: `evaluate` raises, and the answer has no picture.
"""
