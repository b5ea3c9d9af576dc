"""Output of commands: reports, traces, results of runs; as text, JSON and pages."""
