"""Times in ROS 2 (family D): rules that run if a question is about time."""
