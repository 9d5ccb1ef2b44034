"""The column as a user describes it, and as the arrays that the kernels read."""
