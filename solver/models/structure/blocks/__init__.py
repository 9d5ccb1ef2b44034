"""Blocks as built, their faces, and the joints where faces meet."""
