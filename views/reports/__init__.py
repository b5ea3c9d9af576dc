"""Reports: findings of a check as one page, and state spaces over a grid of models as figures."""
