"""A column by the equations of the seed paper and its central differences (kernels/paper/)."""
