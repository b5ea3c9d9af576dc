"""Coloured nets with finite colours, and the plain nets that they represent.

A coloured place holds tokens of one finite sort (module `sorts`); arcs carry terms over variables (`terms`).
`unfolding` makes one plain place of each place and colour, and one plain transition of each transition and
binding of its variables. The mapping back is kept with the net (`origins`).
"""
