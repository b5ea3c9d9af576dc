"""A running net: structure, tokens, enabled transitions, firing and signals; its ports as plain values."""
