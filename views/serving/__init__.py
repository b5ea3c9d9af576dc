"""Pages served on 127.0.0.1: access, addresses, and the end of their server."""
