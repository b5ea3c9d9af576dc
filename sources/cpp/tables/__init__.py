"""Definitions outside of C++ code that its meaning depends on: parameter libraries and plugins."""
