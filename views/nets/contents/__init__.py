"""The content of a picture of a net: nodes, edges and boxes, built from a model, and operations on them."""
