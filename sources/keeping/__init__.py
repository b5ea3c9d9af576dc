"""A cache of the facts of programs between runs."""
