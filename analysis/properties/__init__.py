"""Property files of the Model Checking Contest: read, written, and all answered about one net at once."""
