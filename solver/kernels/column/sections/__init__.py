"""Shapes of contacts: area and moments of any part of one."""
