"""Materials: default density, modulus, strength and friction, each with its source; a measured value is better.

For masonry (Circolare 21/01/2019 n. 7, table C8.5.I) the least strength and the mean modulus, as for knowledge level
LC1.
"""

from __future__ import annotations

from dataclasses import dataclass

FRICTION_OF_MASONRY = 0.577  # reference value of Circolare C8.7.1.2.1.1
DRY_JOINT = 5e9  # N/m3, of a joint of dressed stone without mortar: an estimate, docs/materials.md has 1e9 to 1e10


@dataclass(frozen=True)
class Material:
    """The properties of a material, with their source."""

    density: float  # kg/m3
    young: float  # Pa, Young's modulus of a block, or of masonry with its joints
    strength: float  # Pa, in compression
    friction: float  # coefficient of friction of a joint
    source: str
    has_joints: bool = False  # whether `young` includes the joints between blocks

    def modulus(self, height: float) -> float:
        """Return the Winkler modulus k (N/m3) of a block of height H (m) and its joint: 1 / k = H / E + 1 / k_joint."""
        return 1.0 / (height / self.young + (0.0 if self.has_joints else 1.0 / DRY_JOINT))


_STONE = f"friction: Circolare C8.7.1.2.1.1 ({FRICTION_OF_MASONRY:g})"
_TABLE = f"Circolare 2019, table C8.5.I; {_STONE}"
MATERIALS: dict[str, Material] = {
    "marble": Material(
        2700.0,
        54e9,
        70e6,
        FRICTION_OF_MASONRY,
        f"makeitfrom.com (2700 kg/m3, 54 GPa); strength: least of 70 to 140 MPa, abimpex.com; {_STONE}",
    ),
    "granite": Material(
        2700.0,
        70e9,
        100e6,
        FRICTION_OF_MASONRY,
        "density 2630 to 2750 kg/m3 and least strength 1000 kgf/cm2: ruscetta.fr; 70 GPa: makeitfrom.com; " + _STONE,
    ),
    "concrete": Material(
        2400.0,
        31e9,
        25e6,
        0.6,
        "C25/30 of EN 1992-1-1, table 3.1; friction of smooth faces: its 6.2.5(2); density: EN 1991-1-1, table A.1",
    ),
    "squared-stone": Material(2243.0, 2.85e9, 5.8e6, FRICTION_OF_MASONRY, f"squared stone masonry, {_TABLE}", True),
    "soft-stone": Material(
        1479.0, 1.41e9, 2.0e6, FRICTION_OF_MASONRY, f"regular masonry of tuff or calcarenite, {_TABLE}", True
    ),
    "brick": Material(1835.0, 1.5e9, 2.6e6, FRICTION_OF_MASONRY, f"solid bricks in lime mortar, {_TABLE}", True),
}
