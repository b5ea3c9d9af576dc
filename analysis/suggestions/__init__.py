"""What to change in a model so that a fault is gone, with a proof that it is."""
