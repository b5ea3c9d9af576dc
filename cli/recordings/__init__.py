"""Commands that use recordings of rosbag2."""
