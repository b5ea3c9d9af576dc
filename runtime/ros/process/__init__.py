"""The process of a node: environment, domain, shared memory, session."""
