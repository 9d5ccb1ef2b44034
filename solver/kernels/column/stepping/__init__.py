"""The stepping loop, and the step control and event location that it uses."""
