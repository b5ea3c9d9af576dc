"""Structural reductions of nets with times: irrelevant elements go, and no firing changes its time."""
