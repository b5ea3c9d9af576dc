"""The part of a system that a model can represent, with invented nodes for ends that are missing."""
