"""What runs on which thread and when: the loop of a node, its timers, threads for long work, the watchdog."""
