"""Formulas: their text, their meaning, and what their names and atoms stand for in a net."""
