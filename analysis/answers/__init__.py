"""Budgets, progress and outcomes of questions, shared by all engines."""
