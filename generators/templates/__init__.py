"""The templates of generated files, their rendering, and filters that write values in each format."""

from dineros.generators.templates.rendering import TemplateError, Templates, generator

__all__ = ["TemplateError", "Templates", "generator"]
