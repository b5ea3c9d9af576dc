"""What `check` asks of any model: a module for each question, its faults and its words."""
