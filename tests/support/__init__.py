"""Shared by tests: columns at random, references of our own, FMUs and the processes they run in."""
