"""What a model is to fulfil: the properties stored in it, in words or as formulas, and what they assume."""
