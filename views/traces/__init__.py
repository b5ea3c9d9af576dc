"""The Trace Visualizer: what happened in a net, drawn step by step (paper, Sect. 9, Figs 18 and 19)."""
