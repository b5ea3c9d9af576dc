"""Time Petri nets: exact firing intervals and state classes.

Merlin's intervals with strong semantics: a transition that is enabled fires at the latest when its latest
bound is reached, unless another firing disables it before.
"""
