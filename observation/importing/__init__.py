"""From a system that was seen to a system model with open behaviour."""
