"""Small timed systems of ROS 2, as an independent program describes them, and as system models."""
