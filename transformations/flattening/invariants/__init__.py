"""The place invariants that the rules of flattening guarantee."""
