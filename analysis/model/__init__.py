"""The model behind a net: its names, its words, its queues, its clauses, and what each step means to it."""
