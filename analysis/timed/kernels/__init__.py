"""Kernels of the state class engines."""
