"""Tests of the structural reductions."""
