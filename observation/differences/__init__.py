"""A model against a system that was seen: what is missing, what is extra, what is otherwise."""
