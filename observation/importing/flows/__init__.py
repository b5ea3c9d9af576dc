"""The branches of callbacks that depend on variables of their node."""
