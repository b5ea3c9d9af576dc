"""Rules as data: the rule language, its matcher, and the rules that flatten and split system models."""
