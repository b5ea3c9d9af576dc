"""Random runs of models with their times, and how long their data takes."""
