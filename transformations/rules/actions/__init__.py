"""Actions: goals, slots that work on them, requests to cancel, outcomes and feedback (rules A1 to A7)."""
