"""The portfolio: all decision methods, one scheduler, and one record of known facts about a net."""
