"""Blocks from their shapes: boxes, drums and prisms of uniform density, with mass, inertia and plane faces."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from .faces import Face, FloatArray, polygon_moments
from .parts import Solid

POINTS, WEIGHTS = np.polynomial.legendre.leggauss(4)  # exact for all moments of blocks that taper


def rotation_matrix(vector: FloatArray) -> FloatArray:
    """Return the rotation matrix (3, 3) of a rotation vector, axis times angle in rad."""
    angle = float(np.linalg.norm(vector))
    x, y, z = vector
    across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    half = float(np.sinc(0.5 * angle / np.pi))
    return np.eye(3) + float(np.sinc(angle / np.pi)) * across + 0.5 * half * half * across @ across


def turned(rotation: FloatArray, arm: FloatArray) -> FloatArray:
    """Return the displacement (m) of the end of an arm (3,) or (rows, 3), m, by rotation vectors (rows, 3), rad."""
    angle = np.linalg.norm(rotation, axis=-1, keepdims=True)
    first = np.sinc(angle / np.pi)  # sine over angle
    second = 0.5 * np.sinc(0.5 * angle / np.pi) ** 2
    across = np.cross(rotation, arm)
    return first * across + second * np.cross(rotation, across)


def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the cross products of columns, (3,) or (3, n); for a few numpy's own takes longer than all the rest."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def rotated(q: FloatArray, vector: FloatArray) -> FloatArray:
    """Rotate vectors (3,) or (3, n) by unit quaternions (4,) or (4, n)."""
    across = cross(q[1:], vector)
    return vector + 2.0 * (q[0] * across + cross(q[1:], across))


def rectangle(width: float, depth: float) -> FloatArray:
    """Return the corners of a rectangle about its centre, anticlockwise, (4, 2) m."""
    w, d = 0.5 * width, 0.5 * depth
    return np.array([[-w, -d], [w, -d], [w, d], [-w, d]])


def box(name: str, bottom: tuple[float, float], top: tuple[float, float], height: float, density: float) -> Solid:
    """Return a box standing on the origin, whose bottom and top faces, (width, depth), may differ.

    Lengths are in m, the density in kg/m3.
    """

    def section(part: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        width, depth = (b + (t - b) * part for b, t in zip(bottom, top, strict=True))
        area = width * depth
        return area, area * depth**2 / 12.0, area * width**2 / 12.0

    sides = [rectangle(*bottom), rectangle(*top)]
    faces = [_level(sides[0], 0.0, -1.0), _level(sides[1], height, 1.0)]
    # lateral faces of a box that does not taper
    if bottom == top:
        w, d = bottom
        for normal, width, out in (((1, 0, 0), d, w), ((-1, 0, 0), d, w), ((0, 1, 0), w, d), ((0, -1, 0), w, d)):
            third = np.array(normal, dtype=np.float64)
            second = np.array([0.0, 0.0, 1.0])
            axes = np.column_stack([np.cross(second, third), second, third])
            faces.append(Face(0.5 * out * third + 0.5 * height * second, axes, rectangle(width, height)))
    return _upright(name, section, height, density, faces)


def drum(name: str, diameter: float, top_diameter: float, bore: float, height: float, density: float) -> Solid:
    """Return a drum standing on the origin, conical if its diameters differ, with a cylindrical bore or none.

    Lengths are in m, the density in kg/m3.
    """

    def section(part: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        outer, inner = 0.5 * (diameter + (top_diameter - diameter) * part), 0.5 * bore
        second = 0.25 * math.pi * (outer**4 - inner**4)
        return math.pi * (outer**2 - inner**2), second, second

    faces = [
        _level(np.empty((0, 2)), 0.0, -1.0, 0.5 * diameter, 0.5 * bore),
        _level(np.empty((0, 2)), height, 1.0, 0.5 * top_diameter, 0.5 * bore),
    ]
    return _upright(name, section, height, density, faces)


def prism(name: str, outline: FloatArray, depth: float, density: float) -> Solid:
    """Return the prism of an anticlockwise outline in x and z, (corners, 2) m, over a depth along y (m): a voussoir."""
    # mass properties
    area, first, second = polygon_moments(outline)
    mass, middle = density * area * depth, first / area
    own = second / area - np.outer(middle, middle)
    x, z, xz = mass * own[0, 0], mass * own[1, 1], mass * own[0, 1]
    y = mass * depth**2 / 12.0
    inertia = np.array([[y + z, 0.0, -xz], [0.0, x + z, 0.0], [-xz, 0.0, x + y]])
    # rectangular faces along the outline
    faces = []
    for a, b in zip(outline, np.roll(outline, -1, axis=0), strict=True):
        side = (b - a) / np.linalg.norm(b - a)
        third = np.array([side[1], 0.0, -side[0]])  # outwards of an outline that is anticlockwise in x and z
        first_axis = np.array([side[0], 0.0, side[1]])
        axes = np.column_stack([first_axis, np.cross(third, first_axis), third])
        centre = 0.5 * (a + b)
        faces.append(Face(np.array([centre[0], 0.0, centre[1]]), axes, rectangle(float(np.linalg.norm(b - a)), depth)))
    # both ends
    for way in (1.0, -1.0):
        third = np.array([0.0, way, 0.0])
        axes = np.column_stack([np.array([-way, 0.0, 0.0]), np.array([0.0, 0.0, 1.0]), third])
        flat = np.column_stack([-way * outline[:, 0], outline[:, 1]])
        faces.append(Face(0.5 * depth * third, axes, flat if way < 0.0 else flat[::-1].copy()))
    centroid = np.array([middle[0], 0.0, middle[1]])
    return Solid(name, mass, centroid, inertia, tuple(faces), volume=mass / density)


def _level(outline: FloatArray, height: float, way: float, radius: float = 0.0, bore: float = 0.0) -> Face:
    """Return a horizontal face, seen from outside; way: 1 for a top face, -1 for a bottom face."""
    axes = np.diag([1.0, way, way])
    return Face(np.array([0.0, 0.0, height]), axes, outline, radius, bore)


def _upright(name: str, section: object, height: float, density: float, faces: list[Face]) -> Solid:
    """Return a block from its sections, by Gauss quadrature over the height.

    section: returns the area and the second moments about x and y at relative heights.
    """
    part = 0.5 * (POINTS + 1.0)
    area, about_x, about_y = section(part)  # type: ignore[operator]
    weight = 0.5 * height * WEIGHTS * density
    z = height * part
    mass = float(weight @ area)
    middle = float(weight @ (area * z)) / mass
    upright = float(weight @ (area * (z - middle) ** 2))
    x, y = float(weight @ about_x), float(weight @ about_y)
    inertia = np.diag([x + upright, y + upright, x + y])
    return Solid(name, mass, np.array([0.0, 0.0, middle]), inertia, tuple(faces), volume=mass / density)


def placed(solid: Solid, place: FloatArray, turn: FloatArray) -> Solid:
    """Return the block rotated about the origin by `turn`, (3, 3), and then shifted by `place`, m."""
    groups = solid.faces, solid.hull, *solid.parts
    faces, hull, *parts = (tuple(_placed_face(face, place, turn) for face in part) for part in groups)
    inertia = turn @ solid.inertia @ turn.T
    inertia = 0.5 * (inertia + inertia.T)
    surface, centroid = place + solid.surface @ turn.T, place + turn @ solid.centroid
    solid = replace(solid, faces=faces, hull=hull, parts=tuple(parts))
    return replace(solid, centroid=centroid, inertia=inertia, axes=turn, surface=surface)


def _placed_face(face: Face, place: FloatArray, turn: FloatArray) -> Face:
    return Face(place + turn @ face.centre, turn @ face.axes, face.outline, face.radius, face.bore)
