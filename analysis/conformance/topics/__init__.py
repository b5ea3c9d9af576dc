"""What happens inside of topics, which no record says: queues of ROS 1, histories of ROS 2."""
