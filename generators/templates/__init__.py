"""The templates of what is generated, how they are rendered, and how values are written in each format."""

from dineros.generators.templates.rendering import TemplateError, Templates, generator

__all__ = ["TemplateError", "Templates", "generator"]
