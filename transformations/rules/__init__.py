"""The rules of the paper, the shorthands they are written in, and in which order they run."""
