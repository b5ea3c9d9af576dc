"""Kernels of walks; importing one imports Numba."""
