"""Formulas: their syntax and semantics, and the elements of a net that their names and atoms refer to."""
