"""Reports as pages, and the output of `dineros latency`."""
