"""Answers from parts of a net: some places with the transitions that change them, as few as suffice."""
