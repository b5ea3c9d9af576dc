"""Rules and what they made, for people to read: as text and as pictures."""
