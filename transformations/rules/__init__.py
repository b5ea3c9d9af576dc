"""The rules of the paper, the notation in which they are written, and the order in which they run."""
