"""What was found, shown by firing sequences: what brought an outcome about, and records of it."""
