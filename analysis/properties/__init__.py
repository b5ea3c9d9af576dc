"""Property files of the Model Checking Contest: reading, writing, and answering all properties of a net."""
