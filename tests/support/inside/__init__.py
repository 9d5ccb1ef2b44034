"""Functions that run in the process of an FMU: see child.py."""
