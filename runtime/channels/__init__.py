"""Topics, services and actions of a node, and the transports; this folder has the in-process transport."""
