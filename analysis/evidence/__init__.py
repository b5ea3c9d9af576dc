"""Evidence of answers: certificates of unreachability, and how they are created, written and checked."""
