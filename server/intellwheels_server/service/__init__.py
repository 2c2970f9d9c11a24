"""The simulator as a service: pace, joining, control, inbound and outbound messages, and the Zenoh peer."""
