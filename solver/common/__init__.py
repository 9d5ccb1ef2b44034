"""Tools for every package: errors, files, ranges of numbers, executors."""
