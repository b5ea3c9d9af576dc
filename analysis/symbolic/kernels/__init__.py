"""Kernels on decision diagrams; importing one imports Numba."""
