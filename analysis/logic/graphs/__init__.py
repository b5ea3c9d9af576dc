"""Products of a net and an automaton, stored reachability graphs, and conditions on many markings."""
