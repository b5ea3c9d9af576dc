"""Where things stand in a picture: as the model says, or laid out by ELK."""
