"""Machine code of the kernels: the functions in it as Python calls them, where it is found, and how it is made.

Nothing here imports numba: the compiler is in numba_ext, and runs in a process of its own.
"""
