"""The command line: one module for each command, and the text that it prints."""
