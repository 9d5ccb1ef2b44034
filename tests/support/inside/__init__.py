"""What runs in the process of an FMU: see child.py."""
