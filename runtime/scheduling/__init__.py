"""Threads and times: the loop of a node, its timers, threads for long work, and the watchdog."""
