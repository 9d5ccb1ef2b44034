"""Eight columns at once: the same physics over lanes, each lane with its own column, motion, time and step."""
