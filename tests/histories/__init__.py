"""``python -m tests.histories``: flattened nets of generated models against the interpreter of ROS 2."""
