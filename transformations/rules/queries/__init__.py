"""What rules ask of a model: callbacks, and the arcs around places."""
