"""What `dineros run` does: an application in this process or on ROS 2, watched until it ends."""
