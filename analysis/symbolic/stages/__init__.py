"""State spaces in stages: one component after the other moves."""
