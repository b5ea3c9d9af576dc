"""Guards: conditions over the data of tokens that decide which transitions are enabled, and assignments."""
