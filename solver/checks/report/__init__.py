"""The reports of a check for readers: one HTML file with everything inside."""
