"""Descriptions and pictures of rules and of their results."""
