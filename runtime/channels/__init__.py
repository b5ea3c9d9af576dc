"""Topics and services: what is sent, received, sent again or dropped; transports; that in this process."""
