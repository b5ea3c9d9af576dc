"""A whole application: one process per node, supervised and restarted; the state of all nodes of a run."""
