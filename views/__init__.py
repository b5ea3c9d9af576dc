"""Pictures of models, and the Trace Visualizer (paper, Sect. 9)."""
