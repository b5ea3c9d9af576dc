"""Evidence of answers: certificates of what is unreachable, and how they are found, written and checked."""
