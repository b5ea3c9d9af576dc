"""What differs between two models, as one picture."""
