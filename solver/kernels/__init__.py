"""The compiled kernels: plain functions over floats and contiguous arrays.

Nothing here allocates, raises or touches a Python object, so that the same functions can be compiled ahead of time.
"""
