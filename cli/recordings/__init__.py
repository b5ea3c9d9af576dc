"""What commands do with recordings of rosbag2."""
