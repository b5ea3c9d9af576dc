"""Kernels on products and stored graphs; importing one imports Numba."""
