"""Place/transition nets as arrays, and their structural analysis."""
