"""The simulated cell of the sorting application: two arms, objects, a human, a sensor and a user."""
