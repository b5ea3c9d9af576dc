"""Kernels of the explicit engine; importing one imports Numba."""
