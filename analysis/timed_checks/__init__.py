"""Checks that take the firing intervals of a model into account: what `dineros check --time` asks."""
