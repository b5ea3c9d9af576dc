"""Structural reductions of nets with times: what never decides anything goes, and no firing moves in time."""
