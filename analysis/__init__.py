"""Analysis of nets and of the models behind them: engines, reductions, temporal logic, and what users ask.

Importing this package does not import Numba; the engines do when they are first used.
"""
