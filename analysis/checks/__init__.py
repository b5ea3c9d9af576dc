"""The questions that `check` answers about each model: one module for each, with its faults and texts."""
