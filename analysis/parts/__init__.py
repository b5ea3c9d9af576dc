"""Answers from parts of a net: independent ones, or some places with the transitions that change them."""
