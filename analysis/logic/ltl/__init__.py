"""LTL with fairness: decides whether a product has an accepting run, and finds a short one."""
