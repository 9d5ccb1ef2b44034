"""The solver measured against other integrators and programs: run `python -m benchmarks --help`."""
