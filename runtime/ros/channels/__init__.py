"""The ports of a node as publishers, subscriptions, clients and servers of ROS."""
