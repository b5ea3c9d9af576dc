"""The Petri Net Engine: a runtime model drives one ROS node (paper, Sect. 6)."""
