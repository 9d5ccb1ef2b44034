"""Extensions of numba for kernels: compilation, eight columns at once, names over flat buffers."""
