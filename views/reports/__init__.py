"""Reports: what a check found, as one page; and state spaces over a grid of models, as figures."""
