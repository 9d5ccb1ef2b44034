"""The description of a column, and from it a packed model without its rest and modes."""

import math

from ...layout.spaces import (
    ELASTIC,
    IMPLICIT,
    LAW,
    MOST_STRIPS,
    OK,
    OTHER_LAW,
)
from ...numba_ext.jit import kernel, leaf
from ...numba_ext.views import Record, clear
from ..joint.sliding import RIGID
from ..sections.faces import (
    ENDLESS,
    FITS,
    RECTANGLE,
    FaceShape,
    face_of,
    misfit,
)
from ..sections.section import face, is_off_centre, lay_out
from .assembly import derive
from .solids import homogeneous

# description of a column: settings, then a record for each block; 0: the default of an optional value
# behind them PORTS (layout/spaces.py) of as many ports
GIVEN_SETTINGS = Record("g", "step", "tolerance", "without", "drive", "slope", "bodies", "ports", "bonded")
MORTAR = ("tensile_strength", "cohesion")  # Pa, of a brittle joint
GIVEN_BLOCK = ("height", "width", "depth", "mass", "centroid", "inertia", "tilt")
GIVEN_JOINT = (*LAW, "width", "depth", "friction", "dowel", "offset", "inclination", "rim", *MORTAR)
# fields without a parameter of an FMU: of the block the code of the section, inner diameter m, sizes of the top face
# m; of the joint the code of the section, inner diameter m, number of strips and their depths m
GIVEN_SHAPE = (
    *("section", "bore", "top_width", "top_depth"),
    *("joint_section", "joint_bore", "strips", *(f"strip_{k}" for k in range(MOST_STRIPS))),
)
GIVEN = Record(*GIVEN_BLOCK, *(f"joint_{name}" for name in GIVEN_JOINT), *GIVEN_SHAPE)
# codes of `assemble` (api/engine.py), in addition to those of layout/spaces.py
TOO_LARGE = -10  # the moment of inertia of a block exceeds float64; the detail holds its number
NO_REST = -11  # a column that is off its axis, or has joints of another law, does not stand under its own weight
NOT_LINEAR = -12  # a column that may slide or is off its axis has a joint of another law than the linear one
MISFIT = -13  # a contact face does not fit its faces: the detail holds the joint and the Misfit (faces.py)
UNKNOWN_SECTION = (
    -14
)  # kernels/column/sections/ lacks the section of a block or of its contact: the detail holds its number
DETAILS = 5  # length of the detail


_DEPTHS_GIVEN = GIVEN.fields.index("strip_0")
_LAW_GIVEN, _LAW_FIELDS, _LINEAR_FIELDS = GIVEN.fields.index(f"joint_{LAW[0]}"), len(LAW), len(LAW) - len(OTHER_LAW)
_given_settings, _given_block = GIVEN_SETTINGS.over, GIVEN.over
_SETTINGS_FIELDS, _BLOCK_FIELDS = GIVEN_SETTINGS.beside, GIVEN.beside


@leaf
def behind_blocks(n):
    """Return the place in a description of n blocks behind the blocks."""
    return _SETTINGS_FIELDS + _BLOCK_FIELDS * n


@kernel
def describe(column, given, detail):
    """Fill in a model without its rest and modes, and clear `work`; return a code."""
    model = column.model
    settings, described = model.settings, _given_settings(given, 0)
    settings.n = model.n
    settings.gravity = described.g
    settings.step = described.step
    settings.tolerance = described.tolerance
    settings.without = described.without
    settings.drive, settings.slope, settings.bodies = described.drive, described.slope, described.bodies
    settings.ports, settings.bonded = described.ports, described.bonded
    if settings.bonded != 0.0:
        settings.without = float(int(settings.without) | ELASTIC | IMPLICIT)  # neither method supports bonds
    # flags that blocks may raise
    settings.has_modes = 0.0
    settings.slides = 0.0
    settings.off_axis = 0.0
    # blocks from the top down, each with the joint under it
    for i in range(model.n):
        code = _describe_block(model, given, i, detail)
        if code != OK:
            return code
    settings.slides = max(settings.slides, settings.off_axis)
    derive(model)
    # a contact whose parts have no area that is known
    for i in range(model.n):
        if math.isnan(model.blocks.open_size[i]):
            detail[0] = i + 1.0
            return UNKNOWN_SECTION
    clear(column.work.row, column.work.total)  # modal responses of the previous model
    return OK


@kernel
def _describe_block(model, given, i, detail):
    """Fill in block i and the joint under it from `given`, and the contact from the faces; return a code."""
    n, settings, blocks = model.n, model.settings, model.blocks
    row = given[_SETTINGS_FIELDS + _BLOCK_FIELDS * i :]
    block = _given_block(row, 0)
    blocks.height[i] = block.height
    blocks.mass[i] = block.mass
    # centroid and inertia, those of a homogeneous block by default
    if math.isnan(face(block.section, 1.0, 1.0, 0.5)[0]):
        detail[0] = i + 1.0
        return UNKNOWN_SECTION
    wide, deep, over = block.width, block.depth, (block.top_width, block.top_depth, block.bore)
    centroid, inertia = homogeneous(block.mass, block.section, block.height, wide, deep, *over)
    blocks.centroid[i] = centroid if block.centroid == 0.0 else block.centroid
    blocks.inertia[i] = inertia if block.inertia == 0.0 else block.inertia
    # the law of the joint
    for k in range(_LAW_FIELDS):
        blocks.law[k * n + i] = row[_LAW_GIVEN + k]
    # mortar
    strength = block.joint_tensile_strength
    bonded = settings.bonded != 0.0 and (strength > 0.0 or block.joint_cohesion > 0.0)
    blocks.reach[i] = strength / blocks.stiffness[i] if bonded else -1.0
    blocks.cohesion[i] = block.joint_cohesion
    # the face below, and the contact face
    below = FaceShape(float(RECTANGLE), ENDLESS, ENDLESS, 0.0)
    if i + 1 < n:
        below = _top_face(given[_SETTINGS_FIELDS + _BLOCK_FIELDS * (i + 1) :])
    width = wide if block.joint_width == 0.0 else block.joint_width
    depth = deep if block.joint_depth == 0.0 else block.joint_depth
    bottom = face_of(block.section, wide, deep, block.bore)
    own, depths = face_of(block.joint_section, width, depth, block.joint_bore), row[_DEPTHS_GIVEN:]
    has_width, has_depth = block.joint_width != 0.0, block.joint_depth != 0.0
    # the contact
    fault = misfit(own, bottom, below, has_width, has_depth, int(block.strips), depths)
    if fault.kind != FITS:
        detail[0], detail[1], detail[2] = i + 1.0, fault.kind, fault.strip
        detail[3], detail[4] = fault.value, fault.bound
        return MISFIT
    lay_out(blocks, i, own, block.strips, depths, below, block.joint_rim)
    # sliding, and offsets and inclinations as built
    blocks.friction[i] = block.joint_friction
    blocks.dowel[i] = block.joint_dowel if block.joint_friction > 0.0 else RIGID
    settings.slides = 1.0 if block.joint_friction > 0.0 else settings.slides
    blocks.offset[i], blocks.lean[i] = block.joint_offset, block.joint_inclination
    blocks.tilt[i] = block.joint_inclination + block.tilt
    if block.joint_offset != 0.0 or blocks.lean[i] != 0.0 or blocks.tilt[i] != 0.0:
        settings.off_axis = 1.0
    if is_off_centre(block.strips, depths):
        settings.off_axis = 1.0
    # inertia beyond the range of float64
    if not math.isfinite(blocks.inertia[i]):
        detail[0] = i + 1.0
        return TOO_LARGE
    return OK


@leaf
def _top_face(row):
    """Return the top face of the block that a row of `given` describes."""
    block = _given_block(row, 0)
    width = block.width if block.top_width == 0.0 else block.top_width
    return face_of(block.section, width, block.depth if block.top_depth == 0.0 else block.top_depth, block.bore)


@leaf
def is_linear(given, n):
    """Return True if all joints have the linear law."""
    for i in range(n):
        # coefficients of the terms above the linear one
        row = given[_SETTINGS_FIELDS + _BLOCK_FIELDS * i :]
        for k in range(_LINEAR_FIELDS, _LAW_FIELDS):
            if row[_LAW_GIVEN + k] != 0.0:
                return False
    return True
