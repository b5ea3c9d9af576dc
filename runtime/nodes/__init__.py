"""The `Net` that developers use, and the `Node` that runs it."""
