"""Launch files: which nodes a robot is started with, under which names, with which parameters."""
