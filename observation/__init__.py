"""Existing systems: observed or recorded, imported as models, compared with models, explained by models."""
