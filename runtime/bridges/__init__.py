"""Input signals from outside ROS: set by MQTT or HTTP, or polled by HTTP (extras ``mqtt`` and ``rest``)."""
