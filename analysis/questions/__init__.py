"""The questions that users ask, each answered with the engines."""
