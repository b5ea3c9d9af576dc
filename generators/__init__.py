"""Templates that turn runtime models into ROS 2 packages which their developers extend and keep."""
