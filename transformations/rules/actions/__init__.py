"""Actions: goals, slots that execute them, cancel requests, outcomes and feedback (rules A1 to A7)."""
