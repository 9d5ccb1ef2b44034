"""The kernels as Python and programs without Python call them."""
