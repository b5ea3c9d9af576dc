"""LTL with fairness: whether a product has an accepting run, and a short one of them."""
