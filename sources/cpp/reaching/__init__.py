"""Records which code programs may reach, and have reached."""
