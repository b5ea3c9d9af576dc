"""The reachable markings as the solutions of the place invariants, if that can be proved."""
