"""A whole application: one process per node, watched and restarted; all nodes of a run in one picture."""
