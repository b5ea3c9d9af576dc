"""Time counted in units by a plain net, for nets whose intervals are closed."""
