"""Benchmarks of the solver against other integrators and programs: run `python -m benchmarks --help`."""
