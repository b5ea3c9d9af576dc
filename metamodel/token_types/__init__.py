"""Token types of a model: those it declares, and those that are installed ROS interfaces."""
