"""Findings that a team has accepted: suppressions in the model, and the findings of a baseline."""
