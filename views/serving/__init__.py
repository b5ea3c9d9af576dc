"""Pages that are served on 127.0.0.1: who may see them, where they are, how their server ends."""
