"""What to change in a model to remove a fault, with a proof that it is removed."""
