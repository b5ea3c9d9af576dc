"""Transforms system models to plain nets, with traces and certificates, and to runtime models."""
