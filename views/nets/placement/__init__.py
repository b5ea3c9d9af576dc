"""Positions in a picture: those of the model, or laid out by ELK."""
