"""Ports as publishers, subscriptions, clients and servers of ROS."""
