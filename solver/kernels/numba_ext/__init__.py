"""The parts of numba that kernels need: compilation, eight columns at once, names over flat buffers."""
