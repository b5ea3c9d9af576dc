"""Service calls in a run: their last steps, and their clients."""
