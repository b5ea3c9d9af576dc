"""How long things take in a timed system: response times of callbacks, and latencies of chains."""
