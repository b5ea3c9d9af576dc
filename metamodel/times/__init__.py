"""The times of a system model, with their defaults; how many messages can be in transit."""
