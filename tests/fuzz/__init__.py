"""Fuzzing: what strangers can send to DiNeROS, damaged in all ways; `python -m tests.fuzz --help`."""
