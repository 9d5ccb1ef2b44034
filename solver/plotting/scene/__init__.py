"""A response as a scene in space: as an HTML page that plays it, as glTF for other programs. Without matplotlib."""

from .gltf import write_gltf
from .page import frame_of, write_view
from .vtk import write_vtk

__all__ = ["frame_of", "write_gltf", "write_view", "write_vtk"]
