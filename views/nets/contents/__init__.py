"""What a picture of a net shows: nodes, edges and boxes, made from a model, and operations on them."""
