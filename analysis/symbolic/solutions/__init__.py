"""The reachable markings as the solutions of the place invariants, where that can be proved."""
