"""What commands show: reports, traces, results of runs; as text, as JSON and as pages."""
