"""Facts as JSON, for a cache."""
