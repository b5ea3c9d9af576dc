"""Signals from outside of ROS: MQTT pushes them, REST pushes or is asked (extras ``mqtt`` and ``rest``)."""
