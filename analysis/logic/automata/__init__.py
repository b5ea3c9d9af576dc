"""Automata for formulas of LTL."""
