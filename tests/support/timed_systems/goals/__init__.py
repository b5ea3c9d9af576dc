"""Plain programs that explore goals of actions."""
