"""What is wrong with a system that was seen, before anything is known of its behaviour."""
