"""What a system model says of time, with its defaults; how many messages can be on their way."""
