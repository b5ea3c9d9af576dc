"""A net as developers use it, and the node that runs it."""
