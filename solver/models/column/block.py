"""Blocks, the joints under them, and their valid values."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any

from ...common.errors import InputError, check_number, shown
from ...common.ranges import LENGTH, NUMBERS, check, check_choice
from ...kernels.column.model.solids import homogeneous, solid_between
from ...kernels.column.sections import faces
from ...kernels.column.sections.faces import ANNULUS, SECTIONS, STRIPS, FaceShape, face_of
from ...kernels.column.sections.section import face
from ...kernels.layout.spaces import LAW, MOST_STRIPS, OTHER_LAW

BLOCK_SECTIONS = tuple(name for name in SECTIONS if name != "strips")  # strips are sections of contacts only
_UNKNOWN = [name for name in BLOCK_SECTIONS if math.isnan(face(SECTIONS.index(name), 1.0, 1.0, 0.5)[0])]
assert not _UNKNOWN, f"solver/kernels/column/sections/section.py: face() must have the area of {_UNKNOWN}"


def of_law(least: float, most: float, meaning: str, sections: Collection[str] = SECTIONS) -> Any:
    """Declare a field of `Joint` that, if it is not 0, makes the law other than the linear one (OTHER_LAW).

    `least` and `most` are the range of its key, which includes 0, `meaning` the end of the message for a value out of
    range, as in ranges.py. The law is written for these `sections` of contacts.
    """
    return field(default=0.0, metadata={"range": ((least, most), meaning), "sections": sections})


@dataclass(frozen=True)
class Joint:
    """The no-tension elastic joint under a block."""

    stiffness: float  # N/m3, Winkler modulus: pressure per penetration
    damping: float  # s, eta of the Kelvin-Voigt law; 0 is undamped, which makes a rocking column chaotic
    width: float | None = None  # m, of the contact face along the motion, or its diameter; None: the block's
    depth: float | None = None  # m, of the contact face across the motion, not of a round one; None: the block's
    section: str | None = None  # of the contact, one of SECTIONS; None: the block's
    bore: float | None = None  # m, inner diameter of an annulus; None: the block's
    strips: tuple[float, ...] | None = None  # m, depths of equal strips from -x to +x, 0 for no contact
    friction: float | None = None  # Coulomb's coefficient; None: the joint never slides
    dowel: float | None = None  # N, shear capacity beside friction, which remains as the joint slides
    offset: float | None = None  # m, of the block over what is under it as built, along the joint to +x
    inclination: float | None = None  # rad, of the joint against the base as built, clockwise
    strength: float | None = None  # Pa, strength of the faces in compression; only checks use it, the motion ignores it
    tensile_strength: float = 0.0  # Pa, tensile strength of mortar until it breaks, for good
    cohesion: float = 0.0  # Pa, shear strength of mortar beside friction, until the joint slides
    rim: float | None = None  # m, width of the band along the edges in which the faces touch; None: all over

    def __post_init__(self) -> None:
        if isinstance(self.strips, list):  # TOML and JSON have lists
            object.__setattr__(self, "strips", tuple(self.strips))

    @property
    def is_brittle(self) -> bool:
        """True if it is bonded until it breaks (kernels/column/joint/bond.py)."""
        return bool(self.tensile_strength or self.cohesion)

    @property
    def brittle_key(self) -> str:
        """The key of the strength that makes it brittle, if it is."""
        return "tensile_strength" if self.tensile_strength else "cohesion"

    @property
    def other_law(self) -> str:
        """The key of the parameter that makes its law other than the linear one; "" without one."""
        return next((key for key in OTHER_LAW if getattr(self, key)), "")


_LAWS = {item.name: item.metadata for item in fields(Joint) if item.metadata}
assert set(_LAWS) == set(OTHER_LAW), f"solver/models/column/block.py: Joint must have {OTHER_LAW} by of_law"
NUMBERS.update({key: law["range"] for key, law in _LAWS.items()})


@dataclass(frozen=True)
class Load:
    """A load that rests on a block and rotates with it."""

    mass: float  # kg
    above: float = 0.0  # m, of its centroid above the top face


@dataclass(frozen=True)
class Given:
    """The keys of a file from which mass, centroid and inertia of a block follow, also after its size is varied."""

    mass: float | None = None  # kg, without the load
    density: float | None = None  # kg/m3, in place of mass
    centroid: float | None = None  # m above the bottom face
    inertia: float | None = None  # kg m2
    load: Load | None = None


@dataclass(frozen=True)
class Block:
    """A rigid block and the joint under it.

    Quantities that follow from the shape are computed once, also for blocks that differ in `joint.stiffness` and
    `joint.damping` alone (Column.with_joints).
    """

    height: float  # m
    width: float  # m, along the motion, of the bottom face; the diameter of a round block
    depth: float  # m, across the motion
    mass: float  # kg
    joint: Joint
    centroid: float | None = None  # m above the bottom face; None: that of a homogeneous block
    inertia: float | None = None  # kg m2 about the centroid; None: that of a homogeneous block
    section: str = "rectangle"  # one of BLOCK_SECTIONS
    top_width: float | None = None  # m, of the top face of a tapered block; None: that of the bottom face
    top_depth: float | None = None
    bore: float | None = None  # m, inner diameter of a hollow drum, section annulus
    tilt: float | None = None  # rad, of the block against the normal of the joint under it as built, clockwise
    given: Given | None = field(default=None, compare=False)  # of a file with a density or a load

    def derived(self, given: Given) -> Block:
        """Return the block with the mass, centroid and inertia that follow from its shape and the keys of a file."""
        mass = self.mass if given.mass is None else given.mass
        if given.density is not None:
            mass = given.density * self.volume
        made = replace(self, mass=mass, centroid=given.centroid, inertia=given.inertia, given=given)
        if given.load is None:
            return made
        mass, centroid, inertia = with_load(
            mass, made.resolved_centroid, made.resolved_inertia, given.load.mass, made.height + given.load.above
        )
        return replace(made, mass=mass, centroid=centroid, inertia=inertia)

    @property
    def is_loaded(self) -> bool:
        """True if a load rests on the block."""
        return self.given is not None and self.given.load is not None

    @property
    def is_as_given(self) -> bool:
        """True if mass, centroid and inertia still follow from `given`: no copy of the block has others."""
        return self.given is not None and self == self.derived(self.given)

    @cached_property
    def shape(self) -> tuple[float, float, float, float]:
        """The code of the section, inner diameter, top width and depth (m); 0 where equal to the bottom face."""
        return float(SECTIONS.index(self.section)), self.bore or 0.0, self.top_width or 0.0, self.top_depth or 0.0

    @property
    def volume(self) -> float:
        """The volume of the block (m3)."""
        if self.is_cuboid:
            return self.height * self.width * self.depth
        section, bore, *top = self.shape
        return solid_between(section, self.height, self.width, self.depth, *top, bore).volume

    @cached_property
    def homogeneous(self) -> tuple[float, float]:
        """The centroid (m above the bottom face) and the inertia about it (kg m2) of the homogeneous block."""
        section, bore, *top = self.shape
        middle: float
        turning: float
        middle, turning = homogeneous(self.mass, section, self.height, self.width, self.depth, *top, bore)
        return middle, turning

    @property
    def is_cuboid(self) -> bool:
        """True if the block is a rectangle over its whole height."""
        return self.section == "rectangle" and self.top_width is None and self.top_depth is None

    @cached_property
    def resolved_centroid(self) -> float:
        """The height of the centroid above the bottom face (m)."""
        return self.homogeneous[0] if self.centroid is None else self.centroid

    @cached_property
    def resolved_inertia(self) -> float:
        """The moment of inertia about the centroid (kg m2)."""
        return self.homogeneous[1] if self.inertia is None else self.inertia

    @cached_property
    def joint_section(self) -> int:
        """The code of the section of the block's contact face; the face below may cut it (contact.py)."""
        return SECTIONS.index(self.joint.section or self.section)

    @cached_property
    def joint_bore(self) -> float:
        """The inner diameter of the contact face (m); 0 if it is not an annulus."""
        return (self.joint.bore or self.bore or 0.0) if self.joint_section == ANNULUS else 0.0

    @property
    def contact_face(self) -> FaceShape:
        """The face with which the block may touch the body under it."""
        return face_of(float(self.joint_section), self.joint_width, self.joint_depth, self.joint_bore)

    @property
    def bottom_face(self) -> FaceShape:
        """The whole bottom face."""
        return face_of(self.shape[0], self.width, self.depth, self.bore or 0.0)

    @property
    def top_face(self) -> FaceShape:
        """The face that may carry a block on this one."""
        width, depth = self.top_width or self.width, self.top_depth or self.depth
        return face_of(self.shape[0], width, depth, self.bore or 0.0)

    @cached_property
    def is_off_axis(self) -> bool:
        """True if the block does not stand upright on the middle of the body under it."""
        strips = self.joint.strips
        return bool(self.tilt or self.joint.offset or self.joint.inclination or (strips and strips != strips[::-1]))

    @property
    def joint_width(self) -> float:
        """The width of the contact face (m)."""
        return self.width if self.joint.width is None else self.joint.width

    @property
    def joint_depth(self) -> float:
        """The depth of the contact face (m)."""
        return self.depth if self.joint.depth is None else self.joint.depth


def with_load(mass: float, centroid: float, inertia: float, load: float, place: float) -> tuple[float, float, float]:
    """Return mass (kg), centroid (m above the bottom face) and inertia (kg m2) of a body with a point mass on it.

    The load (kg) is at the height `place` above the bottom face (m); the first three arguments are those of the body.
    """
    both = mass + load
    middle = (mass * centroid + load * place) / both
    return both, middle, inertia + mass * (centroid - middle) ** 2 + load * (place - middle) ** 2


@dataclass(frozen=True)
class Rule:
    """The limits of a number of a block, or of its joint, beside the range of its key in NUMBERS."""

    key: str
    of_joint: bool = False
    optional: bool = False  # follows from other numbers by default
    bound: str = ""  # key of the upper bound among the numbers of the block, exclusive if `strict`
    strict: bool = False
    relation: str = ""


BORE_RELATION = "must be less than the outer diameter"
STRIP_RELATION = "must not exceed the block's depth"
DOWEL_RELATION = "needs friction; a joint without friction never slides"
# kinds of misfits (faces.py) -> the number of the joint that is wrong and its requirement
MISFITS = {
    faces.WIDE: ("width", "must not exceed that of the face below"),
    faces.DEEP: ("depth", "must not exceed that of the face below"),
    faces.WIDE_OWN: ("width", "must not exceed the block's depth"),
    faces.OUTSIDE_OWN: ("diagonal", "must not exceed the diameter of the block, between width and depth"),
    faces.OUTSIDE_BELOW: ("diagonal", "must not exceed the diameter of the face below, between width and depth"),
    faces.SOLID: ("bore", "must be no less than the block's"),
    faces.SOLID_BELOW: ("bore", "must be no less than that of the face below"),
    faces.STRIP_OWN: ("strips", "must not exceed what the block has there"),
    faces.STRIP_BELOW: ("strips", "must not exceed what the face below has there"),
    faces.WITHIN: ("reach", "nothing touches, must exceed the bore of the face below"),
    faces.AROUND: ("bore", "nothing touches, must be less than the face below"),
}
# in the order of the checks
BLOCK_RULES = (
    *(Rule(key) for key in ("height", "width", "depth", "mass")),
    Rule("centroid", False, True, "height", True, "must lie below the top face, height"),
    Rule("inertia", optional=True),
    *(Rule(key, True) for key in LAW),
    *(Rule(key, True, True, key, False, f"must not exceed the block's {key}") for key in ("width", "depth")),
)


def check_block(key: str, block: object) -> None:
    if not isinstance(block, Block):
        raise InputError(f"{key} = {shown(block)}: must be a Block")
    if not isinstance(block.joint, Joint):
        raise InputError(f"{key}.joint = {shown(block.joint)}: must be a Joint")
    # sections, and sizes of the faces
    check_choice(f"{key}.section", block.section, BLOCK_SECTIONS)
    if block.joint.section is not None:
        check_choice(f"{key}.joint.section", block.joint.section, SECTIONS)
    _check_given(key, block, "top_width", "top_depth", "bore")
    _check_given(f"{key}.joint", block.joint, "bore")
    sizes = tuple(rule for rule in BLOCK_RULES if not (rule.of_joint or rule.optional))
    _check_rules(key, block, sizes)
    if block.section == "annulus" and block.bore is None:
        raise InputError(f"{key}.bore: missing, must be {NUMBERS['bore'][1]}: the inner diameter")
    narrowest = min(block.width, block.top_width or block.width)
    _check_bore(key, block.bore, block.section, narrowest)
    rules = tuple(rule for rule in BLOCK_RULES if rule not in sizes)
    body = block
    if block.is_loaded:  # the common centroid may be above the body
        check(f"{key}.centroid", block.resolved_centroid)
        body = replace(block, centroid=block.given.centroid if block.given else None)
    _check_rules(key, body, rules)
    # the contact face
    _check_bore(f"{key}.joint", block.joint.bore, SECTIONS[block.joint_section], block.joint_width)
    if block.joint_section == ANNULUS:
        if not block.joint_bore:
            width = shown(block.joint_width)
            raise InputError(f"{key}.joint.bore: must be an inner diameter in m, less than {width} m")
        _check_bore(f"{key}.joint", block.joint_bore, "annulus", block.joint_width)
    _check_strips(f"{key}.joint.strips", block)
    # numbers of the joint and the tilt
    _check_given(f"{key}.joint", block.joint, "offset", "inclination", "rim")
    if block.joint.rim is not None and (why := no_rim(block)):
        raise InputError(f"{key}.joint.rim = {shown(block.joint.rim)}: must be {why}")
    _check_given(key, block, "tilt")
    # other laws are written for some sections only
    for name in OTHER_LAW:
        value = getattr(block.joint, name)
        if value and not knows_section(name, block):
            known = " or ".join(f'"{section}"' for section in _LAWS[name]["sections"])
            raise InputError(f"{key}.joint.{name} = {shown(value)}: must be left out, or the contact's section {known}")


def no_rim(block: Block) -> str:
    """Return the reason why the joint under a block can have no rim, or ""."""
    if not faces.is_known(block.joint_section):
        return f'left out where the section is "{SECTIONS[block.joint_section]}"'
    if block.joint_section == STRIPS:
        return 'left out beside section = "strips", which says where the faces touch'
    return "left out of a joint that bears tension or cohesion" if block.joint.is_brittle else ""


def knows_section(name: str, block: Block) -> bool:
    """Return True if the law with the parameter `name` is written for the section of the contact under a block."""
    return SECTIONS[block.joint_section] in _LAWS[name]["sections"]


def _check_rules(key: str, block: Block, rules: Sequence[Rule]) -> None:
    for rule in rules:
        name = f"{key}.joint.{rule.key}" if rule.of_joint else f"{key}.{rule.key}"
        value = check(name, _resolved(block, rule))
        bound = getattr(block, rule.bound) if rule.bound else None
        if bound is not None and (value >= bound if rule.strict else value > bound):
            raise InputError(f"{name} = {shown(value)}: {rule.relation} = {shown(bound)} m")


def _check_bore(owner: str, bore: float | None, section: str, width: float) -> None:
    if bore is not None and section != "annulus":
        raise InputError(f'{owner}.bore = {shown(bore)}: must be left out, or section = "annulus"')
    if bore is not None and bore >= width:
        raise InputError(f"{owner}.bore = {shown(bore)}: {BORE_RELATION} = {shown(width)} m")


def _check_given(key: str, part: Block | Joint, *names: str) -> None:
    """Check the range of numbers that may be None."""
    for name in names:
        if (value := getattr(part, name)) is not None:
            check(f"{key}.{name}", value)


def _check_strips(key: str, block: Block) -> None:
    strips = block.joint.strips
    if block.joint_section != STRIPS:
        if strips is not None:
            raise InputError(f'{key} = {shown(strips)}: must be left out, or section = "strips"')
        return
    for k, depth in enumerate(check_depths(key, strips)):
        if depth > block.depth:
            raise InputError(f"{key}[{k}] = {shown(depth)}: {STRIP_RELATION} = {shown(block.depth)} m")


def check_depths(key: str, strips: object) -> Sequence[float]:
    """Return the depths of strips (m). Raises InputError."""
    if not isinstance(strips, (list, tuple)) or not 1 <= len(strips) <= MOST_STRIPS:
        raise InputError(f"{key} = {shown(strips)}: must be a list of 1 to {MOST_STRIPS} depths in m")
    for k, depth in enumerate(strips):
        check_number(f"{key}[{k}]", depth, (0.0, LENGTH[0][1]), "a depth in m, from 0 to that of the block")
    if not any(strips):
        raise InputError(f"{key}: all zero, must have a depth somewhere")
    return strips


def _resolved(block: Block, rule: Rule) -> object:
    """Return the number that a rule applies to, given or derived from others."""
    if rule.of_joint:
        return getattr(block, f"joint_{rule.key}") if rule.optional else getattr(block.joint, rule.key)
    return getattr(block, f"resolved_{rule.key}" if rule.optional else rule.key)


def check_friction(key: str, joint: Joint) -> None:
    _check_given(key, joint, "friction", "dowel", "strength", "tensile_strength", "cohesion")
    if joint.dowel is not None and joint.friction is None:
        raise InputError(f"{key}.dowel = {shown(joint.dowel)}: {DOWEL_RELATION}")
    if joint.cohesion and joint.friction is None:
        raise InputError(f"{key}.cohesion = {shown(joint.cohesion)}: {DOWEL_RELATION}")
