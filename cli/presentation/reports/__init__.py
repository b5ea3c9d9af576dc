"""Reports as pages, and what `dineros latency` prints."""
