"""What a temporal question may cost, and what is answered."""
