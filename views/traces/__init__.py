"""The Trace Visualizer: runs of a net, drawn step by step (paper, Sect. 9, Figs 18 and 19)."""
