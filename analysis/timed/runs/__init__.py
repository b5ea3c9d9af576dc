"""Runs through graphs of state classes: with an automaton that reads them, and with infinite time."""
