"""Products of a net and an automaton, and stored reachability graphs."""
