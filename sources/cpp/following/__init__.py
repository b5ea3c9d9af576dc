"""The interpreter of C++: what code says is followed, and nothing is run."""
