"""A response as a scene in space: as an HTML page that plays it, as glTF for other programs. Without matplotlib."""
