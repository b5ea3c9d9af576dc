"""Reads C++ into facts, without a compiler: an index of all files, and an interpreter for nodes."""
