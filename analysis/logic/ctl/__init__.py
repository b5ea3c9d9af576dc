"""CTL: the states that satisfy a formula, on stored graphs and on decision diagrams."""
