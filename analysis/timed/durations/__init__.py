"""Questions about lengths of time: the quickest way, and what happens within a time."""
