"""Findings that follow from another one: decided by asking again in a model without that one."""
