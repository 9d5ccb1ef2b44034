"""What the kernels need of numba: compilation, eight columns at once, names over flat buffers."""
