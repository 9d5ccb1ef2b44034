"""A program that runs a kernel of the smallest group of machine code: for processes that compile it."""

# the area of a disc of radius 1 m over pi, from its first moment about a tangent
PROGRAM = """
import numpy as np
from solver.kernels.column.api.entries import rings_beyond
first, second = np.empty(1), np.empty(1)
rings_beyond(np.ones(1), np.zeros(1), np.array([-1.0]), first, second)
print(first[0] / np.pi)
"""
