"""What rclpy and other libraries do, as far as it matters for facts."""
