"""What a system model says of time: each time must be of something that can take it."""
