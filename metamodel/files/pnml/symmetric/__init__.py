"""Symmetric nets (ISO/IEC 15909-2), coloured nets with finite colours, are unfolded when they are read.

`declarations` reads sorts, variables and constants, `term_reader` the terms of places, arcs and conditions,
`reader` the net, and `building` makes the plain net.
"""
