"""What a question may cost, how far its answer is, and what is answered: one of each for all engines."""
