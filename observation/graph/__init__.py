"""A running graph of ROS 2, as its nodes announce it."""
