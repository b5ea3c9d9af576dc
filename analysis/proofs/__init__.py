"""Proofs that look at no state space: by linear algebra, traps and induction."""
