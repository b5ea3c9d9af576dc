"""A net as it runs: structure, tokens, enabled transitions, firing, signals; its ports as plain values."""
