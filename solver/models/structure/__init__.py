"""Structures of rigid blocks in space: their description, rest, modes, runs and responses."""
