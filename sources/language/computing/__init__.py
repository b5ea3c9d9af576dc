"""Values of operators, constants, lists and dictionaries."""
