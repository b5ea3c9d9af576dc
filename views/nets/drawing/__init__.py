"""Pictures as SVG, as PNG, and as pages for a browser."""
