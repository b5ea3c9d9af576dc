"""Times of ROS 2 (family D): rules that run where a question asks about time."""
