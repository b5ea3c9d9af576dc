"""Analysis of nets: compiled nets, structure, explicit and symbolic state spaces.

Importing this package does not import Numba; the engines do when they are first used.
"""
