"""Programs in Python: which a folder has, and what they do."""
