"""The rules of the paper, the shorthands they are written in, and when they run."""
