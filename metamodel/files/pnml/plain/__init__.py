"""P/T nets in the PNML of other tools: their forms of the file, and of markings, weights and arc types."""
