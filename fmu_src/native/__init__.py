"""The native FMU, without Python: kernels compiled ahead of time, linked with a thin layer of C."""
