"""A gallery: many objects, each under several mounts, against one seismic action."""
