"""What can become of goals of actions, as questions of a check."""
