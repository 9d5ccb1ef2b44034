"""A column says what it is made of, or in one line why it cannot be."""

import dataclasses
import json
import tomllib
import warnings
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from solver.common.errors import InputError, InputWarning
from solver.common.ranges import MAX_BLOCKS
from solver.models.column.block import Block, Joint
from solver.models.column.kinematics import chain_of
from solver.models.column.lane_policy import reason_against_lanes
from solver.models.column.model import Column
from solver.models.column.packing import described
from solver.models.column.rest import is_stable
from solver.models.column.settings import Settings

EXAMPLES = Path(__file__).resolve().parents[2] / "examples" / "columns"

PHOCAS_BLOCK = Block(4.69, 1.56, 1.56, 27000.0, Joint(533 * 9.80665e6, 0.0))

TOML = """
name = "two"
g = 9.81
[[block]]
height = 2
width = 1.0
depth = 0.5
mass = 3000.0
centroid = 0.9
inertia = 1500.0
[block.joint]
stiffness = 1e9
damping = 2e-3
width = 0.8
depth = 0.4
[[block]]
height = 3.0
width = 1.0
depth = 0.5
density = 2000.0
[joint]
stiffness = 5e8
damping = 1e-3
[solver]
formulation = "paper"
integrator = "central-difference"
step = 2e-4
tolerance = 1e-6
"""


def positive(largest: float) -> st.SearchStrategy[float]:
    return st.floats(1e-3, largest)


@st.composite
def blocks(draw: st.DrawFn) -> Block:
    height, width, depth = (draw(positive(50.0)) for _ in range(3))
    part = st.none() | st.floats(0.01, 0.99)
    centroid, contact_width, contact_depth = (
        None if (share := draw(part)) is None else share * length for length in (height, width, depth)
    )
    joint = Joint(draw(positive(1e12)), draw(st.floats(0.0, 1.0)), contact_width, contact_depth)
    return Block(height, width, depth, draw(positive(1e6)), joint, centroid, draw(st.none() | positive(1e6)))


def upon_each_other(blocks: list[Block]) -> tuple[Block, ...]:
    """Return the blocks, no contact face larger than the face below where its size is given."""
    made = list(blocks)
    for k, (block, below) in enumerate(pairwise(blocks)):
        joint = block.joint
        width, depth = (
            given and min(given, most) for given, most in ((joint.width, below.width), (joint.depth, below.depth))
        )
        made[k] = replace(block, joint=replace(joint, width=width, depth=depth))
    return tuple(made)


columns = st.builds(
    Column,
    name=st.from_regex("[A-Za-z_][A-Za-z0-9_]*", fullmatch=True),
    blocks=st.lists(blocks(), min_size=1, max_size=5).map(upon_each_other),
    settings=st.builds(Settings, st.just("paper"), st.just(""), positive(1.0), st.floats(1e-13, 0.1))
    | st.builds(Settings, tolerance=st.floats(1e-13, 0.1)),
    g=st.floats(0.0, 100.0),
)


def column(**changes: Any) -> Column:
    return Column(**{"name": "phocas", "blocks": (PHOCAS_BLOCK,) * 3, **changes})


def from_text(folder: Path, text: str) -> Column:
    path = folder / "column.toml"
    path.write_text(text, encoding="utf-8")
    return Column.from_toml(path)


def test_toml_gives_every_value(tmp_path: Path) -> None:
    assert from_text(tmp_path, TOML) == Column(
        "two",
        (
            Block(2.0, 1.0, 0.5, 3000.0, Joint(1e9, 2e-3, 0.8, 0.4), 0.9, 1500.0),
            Block(3.0, 1.0, 0.5, 3000.0, Joint(5e8, 1e-3)),
        ),
        Settings("paper", "central-difference", 2e-4, 1e-6),
        9.81,
    )


def test_toml_integers_become_floats(tmp_path: Path) -> None:
    assert isinstance(from_text(tmp_path, TOML).blocks[0].height, float)


def test_defaults_of_what_toml_leaves_out() -> None:
    block = {"height": 1.0, "width": 1.0, "depth": 1.0, "mass": 1.0, "joint": {"stiffness": 1.0, "damping": 0.0}}
    assert Column.from_dict({"name": "a", "block": [block]}) == Column(
        "a", (Block(1.0, 1.0, 1.0, 1.0, Joint(1.0, 0.0)),)
    )


def test_phocas_example_is_the_papers() -> None:
    assert Column.from_toml(EXAMPLES / "phocas.toml") == column(
        settings=Settings("paper", "central-difference", step=1e-4)
    )


def test_damped_phocas_example() -> None:
    block = dataclasses.replace(PHOCAS_BLOCK, joint=Joint(5226944450.0, 1e-3))
    assert Column.from_toml(EXAMPLES / "phocas-damped.toml") == Column("phocas_damped", (block,) * 3)


def test_values_that_follow_from_others() -> None:
    assert PHOCAS_BLOCK.resolved_centroid == 2.345
    assert PHOCAS_BLOCK.resolved_inertia == pytest.approx(27000.0 * (4.69**2 + 1.56**2) / 12.0)
    assert (PHOCAS_BLOCK.joint_width, PHOCAS_BLOCK.joint_depth) == (1.56, 1.56)


def test_values_that_are_given() -> None:
    block = Block(2.0, 1.0, 0.5, 3000.0, Joint(1e9, 0.0, width=0.8, depth=0.4), centroid=0.9, inertia=1500.0)
    assert (block.resolved_centroid, block.resolved_inertia) == (0.9, 1500.0)
    assert (block.joint_width, block.joint_depth) == (0.8, 0.4)


@given(columns)
def test_dict_round_trip(made: Column) -> None:
    assert Column.from_dict(made.to_dict()) == made


@given(columns)
def test_dict_survives_json(made: Column) -> None:
    assert Column.from_dict(json.loads(json.dumps(made.to_dict()))) == made


def test_numpy_scalars_are_numbers() -> None:
    made = column(blocks=[Block(np.float32(4.0), np.int64(1), 1.0, 1.0, Joint(1e9, 0.0))])  # type: ignore[arg-type]
    assert Column.from_dict(json.loads(json.dumps(made.to_dict()))) == made


def test_damping_is_written() -> None:
    with pytest.raises(TypeError, match="damping"):
        Joint(1e9)  # type: ignore[call-arg]


def test_block_count() -> None:
    assert column(blocks=[PHOCAS_BLOCK] * MAX_BLOCKS).n == MAX_BLOCKS
    for count in (0, MAX_BLOCKS + 1):
        with pytest.raises(InputError, match=f"^block: {count} blocks, must be 1 to 1000$"):
            column(blocks=[PHOCAS_BLOCK] * count)


def test_with_settings_changes_what_is_given() -> None:
    changed = column().with_settings(formulation="paper", step=1e-3, tolerance=None)
    assert changed == column(settings=Settings(formulation="paper", step=1e-3))
    assert column().with_settings() == column()


def test_the_exact_formulation_keeps_no_step() -> None:
    exact = column(settings=Settings("paper", step=1e-3)).with_settings(formulation="exact")
    assert "step" not in exact.to_dict()["solver"]
    assert Column.from_dict(exact.to_dict()) == exact == column()


def test_with_settings_is_checked() -> None:
    with pytest.raises(InputError, match=r"^solver\.step = -1: must be a positive time in s, from 1e-9 to 1e6$"):
        column().with_settings(step=-1)


@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), float("inf"), True, "1", None, 10**400])
@pytest.mark.parametrize("key", ["height", "width", "depth", "mass", "joint.stiffness"])
def test_blocks_made_by_hand_are_checked(key: str, value: Any) -> None:
    if key.startswith("joint."):
        block = dataclasses.replace(PHOCAS_BLOCK, joint=Joint(value, 0.0))
    else:
        block = dataclasses.replace(PHOCAS_BLOCK, **{key: value})
    with pytest.raises(InputError, match=rf"^block\[2\].{key} = .*: must be a positive .+$"):
        column(blocks=(PHOCAS_BLOCK, block))


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"blocks": ("stone",)}, "block[1] = 'stone': must be a Block"),
        ({"blocks": (Block(1.0, 1.0, 1.0, 1.0, 1e9),)}, "block[1].joint = 1000000000.0: must be a Joint"),  # type: ignore[arg-type]
        ({"settings": "paper"}, "solver = 'paper': must be Settings"),
        ({"g": -9.8}, "g = -9.8: must be an acceleration in m/s2, zero or positive"),
        (
            {"blocks": (Block(1e200, 1.0, 1.0, 1.0, Joint(1.0, 0.0)),)},
            "block[1].height = 1e+200: must be a positive length",
        ),
        (
            {"blocks": (Block(1e-300, 1.0, 1.0, 1.0, Joint(1.0, 0.0)),)},
            "block[1].height = 1e-300: must be a positive length",
        ),
        ({"blocks": (Block(1e-5, 1e-6, 1.0, 1e-12, Joint(1.0, 0.0)),)}, "block[1].mass = 1e-12: must be"),
    ],
)
def test_columns_made_by_hand_are_checked(changes: dict[str, object], said: str) -> None:
    with pytest.raises(InputError) as caught:
        column(**changes)
    assert str(caught.value).startswith(said)


# what a user may write wrong: (text in TOML, what stands there instead, what the message says)
BAD = [
    ('name = "two"', "", "name: missing, must be a file name"),
    ('name = "two"', "name = 2", "name = 2: must be a file name of letters, digits"),
    *(
        ('name = "two"', f"name = '{name}'", f"name = '{name}': must be a file name of letters, digits")
        for name in ("", "../two", "/two", "a/b", "..", ".two", " two", "two ", "two.", "-two", "a:b")
    ),
    ("g = 9.81", "g = 9,81", "9,81 has a decimal comma, must be 9.81 with a decimal point"),
    ("g = 9.81", "g = -9,81 # m/s2", "-9,81 has a decimal comma, must be -9.81 with a decimal point"),
    (
        'name = "two"',
        'nam = "two"',
        "nam: unknown key, must be one of name, g, material, block, joint, solver, profile, port; did you mean name?",
    ),
    ("g = 9.81", '"g\\n" = 9.81', r"g\n: unknown key, must be one of"),
    ("g = 9.81", "g = nan", "g = nan: must be an acceleration"),
    ("g = 9.81", "g = {}", "g = {}: must be an acceleration"),
    ("height = 3.0", "height = -4.69", "block[2].height = -4.69: must be a positive length in m"),
    ("height = 3.0", "height = inf", "block[2].height = inf: must be"),
    ("height = 3.0", 'height = "3"', "block[2].height = '3': must be"),
    ("height = 3.0", "height = true", "block[2].height = True: must be"),
    ("height = 3.0", "height = [3]", "block[2].height = [3]: must be"),
    ("height = 3.0", "height.m = 3", "block[2].height = {'m': 3}: must be"),
    ("height = 3.0", f"height = 1{'0' * 400}", "block[2].height = a whole number of about 400 digits"),
    ("height = 3.0", "", "block[2].height: missing, must be a positive length in m"),
    (
        "height = 3.0",
        "Height = 3.0",
        "block[2].Height: unknown key, must be one of height, width, depth, mass, density",
    ),
    ("height = 3.0", "Height = 3.0", "; did you mean height?"),
    ("density = 2000.0", "", "block[2].mass, block[2].density: missing, must be exactly one"),
    ("density = 2000.0", "density = 1\nmass = 1", "block[2].mass, block[2].density: both given, must be exactly one"),
    ("density = 2000.0", "density = 0", "block[2].density = 0: must be a positive density in kg/m3"),
    ("density = 2000.0", "density = 1e308", "block[2].density = 1e+308: must be"),
    ("centroid = 0.9", "centroid = 2.0", "block[1].centroid = 2.0: must lie below the top face, height = 2.0 m"),
    ("centroid = 0.9", "centroid = 0", "block[1].centroid = 0: must be a positive length in m"),
    ("inertia = 1500.0", "inertia = -1", "block[1].inertia = -1: must be a positive moment of inertia in kg m2"),
    ("width = 0.8", "width = 1.01", "block[1].joint.width = 1.01: must not exceed the block's width = 1.0 m"),
    ("depth = 0.4", "depth = 0.6", "block[1].joint.depth = 0.6: must not exceed the block's depth = 0.5 m"),
    ("damping = 2e-3", "damping = true", "block[1].joint.damping = True: must be a time in s"),
    ("damping = 2e-3", "damping = -1e-3", "block[1].joint.damping = -0.001: must be a time in s, zero or positive"),
    (
        "damping = 2e-3",
        "dampig = 1",
        "block[1].joint.dampig: unknown key, must be one of stiffness, damping, width, depth",
    ),
    (
        "damping = 1e-3",
        "",
        "block[2].joint.damping: missing, must be a time in s, zero or positive, at most 1e6; 0 if none",
    ),
    ("damping = 1e-3", "", "an undamped rocking column is chaotic"),
    ("stiffness = 5e8", "", "block[2].joint.stiffness: missing, must be a positive Winkler modulus in N/m3"),
    ("stiffness = 5e8", 'stiffness = "stiff"', "joint.stiffness = 'stiff': must be a positive Winkler modulus"),
    ("stiffness = 5e8", "stifness = 5e8", "joint.stifness: unknown key"),
    ("[block.joint]\n", "joint = 1\n[block.jont]\n", "block[1].jont: unknown key"),
    (
        "[joint]\n",
        "[joints]\n",
        "joints: unknown key, must be one of name, g, material, block, joint, solver, profile, port; "
        "did you mean joint?",
    ),
    ('"paper"', '"papr"', "solver.formulation = 'papr': must be one of exact, paper; did you mean paper?"),
    ('"paper"', "1", "solver.formulation = 1: must be one of exact, paper"),
    (
        '"central-difference"',
        '"auto"',
        """solver.integrator = 'auto': must be "central-difference", or left out, where the formulation is paper""",
    ),
    (
        '"paper"\nintegrator = "central-difference"\nstep = 2e-4\n',
        '"exact"\nintegrator = "central-difference"\n',
        "solver.integrator = 'central-difference': must be \"auto\", or left out",
    ),
    (
        'formulation = "paper"\nintegrator = "central-difference"\n',
        "",
        "solver.step = 0.0002: must be left out, the exact formulation adapts its steps to the tolerance",
    ),
    ("step = 2e-4", "step = 0", "solver.step = 0: must be a positive time in s"),
    ("tolerance = 1e-6", "tolerance = 1e-14", "solver.tolerance = 1e-14: must be a number from 1e-13 to 0.1"),
    ("tolerance = 1e-6", "tolerance = 0.2", "solver.tolerance = 0.2: must be a number from 1e-13 to 0.1"),
    ("tolerance = 1e-6", "tolerence = 1e-6", "solver.tolerence: unknown key"),
    (TOML, 'name = "a"', "block: missing, must be one table [[block]] for each block, from the top down"),
    (TOML, 'name = "a"\n[block]\nheight = 1', "block: is not an array of tables, must be one table [[block]]"),
    (TOML, 'name = "a"\nblock = [1]', "block: is not an array of tables"),
    (TOML, 'name = "a"\nblock = []', "block: 0 blocks, must be 1 to 1000"),
    (TOML, 'name = "a"\njoint = 1', "joint = 1: must be a table with the keys stiffness, damping, width, depth"),
    (TOML, 'name = "a', "Unterminated string (at"),
]


@pytest.mark.parametrize(("text", "instead", "said"), BAD)
def test_bad_toml(tmp_path: Path, text: str, instead: str, said: str) -> None:
    assert text in TOML
    with pytest.raises(InputError) as caught:
        from_text(tmp_path, TOML.replace(text, instead, 1))
    message = str(caught.value)
    assert message.startswith(f"{tmp_path / 'column.toml'}: ")
    assert said in message
    assert "\n" not in message


@pytest.mark.parametrize("name", ["my-doric", "2-two", "St. Peter", "a.b_c-d 9", "_"])
def test_names_are_those_of_files(tmp_path: Path, name: str) -> None:
    assert from_text(tmp_path, TOML.replace('"two"', f'"{name}"')).name == name


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16"])
def test_a_byte_order_mark_is_called_by_its_name(tmp_path: Path, encoding: str) -> None:
    path = tmp_path / "marked.toml"
    path.write_text(TOML, encoding=encoding)
    with pytest.raises(InputError, match=r"marked\.toml: begins with a byte order mark \(BOM\) of UTF-"):
        Column.from_toml(path)


def test_a_comma_is_blamed_only_where_it_is_one_of_decimals(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"at line \d+"):
        from_text(tmp_path, TOML.replace("g = 9.81", "g = [9,81"))


ROUND = """name = "round"
[[block]]
section = "circle"
height = 1.0
density = 2000.0
joint = { stiffness = 1e10, damping = 1e-3 }
"""


def test_a_round_block_has_a_diameter(tmp_path: Path) -> None:
    for key, instead in (("width", "diameter"), ("depth", "diameter"), ("top_width", "top_diameter")):
        text = ROUND + (f"{key} = 1.0\n" if instead == "diameter" else f"diameter = 1.0\n{key} = 1.0\n")
        with pytest.raises(InputError, match=rf"block\[1\]\.{key}: must be left out, give {instead}: a round block"):
            from_text(tmp_path, text)


def test_keys_that_no_block_uses_are_warned_of(tmp_path: Path) -> None:
    def warned(text: str) -> list[str]:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            from_text(tmp_path, text)
        return [str(warning.message) for warning in caught if warning.category is InputWarning]

    metres, millimetres = "profile = [[0.0, 0.9], [1.2, 0.8]]\n", "profile = [[0, 900], [1200, 800]]\n"
    assert warned(metres + ROUND) == []
    assert warned(millimetres + ROUND) == [
        "profile: reaches up to 1200 m, the column to 1 m; heights and diameters are in m"
    ]
    beyond = ", its blocks from 0 to 1 m; beyond it their diameters are constant"
    assert warned(metres.replace("1.2", "0.9") + ROUND) == ["profile: reaches from 0 to 0.9 m" + beyond]
    assert warned(metres.replace("0.0", "0.1") + ROUND) == ["profile: reaches from 0.1 to 1.2 m" + beyond]
    assert warned(metres.replace("1.2", "0.9995") + ROUND) == []
    with pytest.raises(InputError, match=r"block\[1\].top_diameter: must be left out, or given with diameter"):
        warned(metres + ROUND + "top_diameter = 0.8\n")
    (said,) = warned(metres + ROUND + "diameter = 1.0\n")
    assert said.startswith("profile: no block uses it")
    assert warned(ROUND.replace("[[block]]", "joint = { friction = 0.7 }\n[[block]]") + "diameter = 1.0\n") == []
    (said,) = warned(ROUND.replace("[[block]]", "joint = { damping = 2e-3 }\n[[block]]") + "diameter = 1.0\n")
    assert said == "joint.damping: no block uses it, each has a joint.damping of its own"


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ('joint = { section = "ball" }', "joint.section = 'ball': must be one of rectangle"),
        ("joint = { section = 3 }", "joint.section = 3: must be one of rectangle"),
        ('joint = { strips = "wide" }', "joint.strips = 'wide': must be a list of 1 to"),
        ("joint = { strips = [0.1, -0.1] }", "joint.strips[1] = -0.1: must be a depth in m"),
        ('material = "marbel"', "material = 'marbel': must be one of"),
    ],
)
def test_defaults_that_every_block_overrides_are_checked(tmp_path: Path, line: str, said: str) -> None:
    """Check the words of the common joint and the material, which only blocks without their own used."""
    own = 'material = "marble"\nwidth = 1.0\ndepth = 1.0\n'
    own += 'joint = { section = "strips", strips = [0.5, 0.0, 0.5], stiffness = 1e10, damping = 1e-3 }\n'
    with pytest.raises(InputError) as caught:
        from_text(tmp_path, f'name = "a"\n{line}\n[[block]]\nheight = 1.0\n{own}')
    assert str(caught.value).startswith(f"{tmp_path / 'column.toml'}: {said}")


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"absent\.toml: No such file or directory$"):
        Column.from_toml(tmp_path / "absent.toml")
    with pytest.raises(InputError, match=f"{tmp_path}: Is a directory$"):
        Column.from_toml(tmp_path)
    (tmp_path / "latin.toml").write_bytes(b'name = "\xe9"')
    with pytest.raises(InputError, match=r"latin\.toml: is not UTF-8 text"):
        Column.from_toml(tmp_path / "latin.toml")


def test_what_is_remembered_of_a_column_does_not_hang_on_its_joints() -> None:
    """Check that columns that differ in moduli, dampings and settings share what was worked out of their shape."""
    for name in ("phocas-damped.toml", "phocas-round.toml"):
        column = Column.from_toml(EXAMPLES / name)
        described(column), is_stable(column), reason_against_lanes(column)
        n = column.n
        changed = column.with_settings(tolerance=1e-5).with_joints(
            [1e9 + i for i in range(n)], [1e-3 * i for i in range(n)]
        )
        again = Column.from_dict(changed.to_dict())
        assert changed == again
        np.testing.assert_array_equal(described(changed), described(again))
        for block, other in zip(changed.blocks, again.blocks, strict=True):
            assert {key: getattr(block, key) for key in vars(block)} == {
                key: getattr(other, key) for key in vars(block)
            }
        assert changed.springs == again.springs
        assert {key: getattr(changed, key) for key in vars(changed)} == {
            key: getattr(again, key) for key in vars(changed)
        }


def test_the_other_direction_exchanges_widths_and_depths() -> None:
    """Check that exchanging twice gives the column itself; the inertia that is given keeps what it has beyond a
    homogeneous block.
    """
    column = replace(Column.from_dict(tomllib.loads(TOML)), settings=Settings())
    turned = column.across()
    assert turned.name == "two across"
    assert [(block.width, block.depth) for block in turned.blocks] == [(0.5, 1.0)] * 2
    assert (turned.blocks[0].joint_width, turned.blocks[0].joint_depth) == (0.4, 0.8)
    beyond = 1500.0 - 3000.0 / 12.0 * (2.0**2 + 1.0**2)
    assert turned.blocks[0].resolved_inertia == pytest.approx(beyond + 3000.0 / 12.0 * (2.0**2 + 0.5**2), rel=1e-12)
    back = replace(turned.across(), name=column.name)
    assert back.blocks[0].inertia == pytest.approx(1500.0, rel=1e-12)
    assert replace(back.blocks[0], inertia=1500.0) == column.blocks[0]
    assert back.blocks[1] == column.blocks[1]
    assert not column.is_alike_across
    leaning = replace(column, blocks=tuple(replace(block, tilt=0.01) for block in column.blocks))
    with pytest.raises(InputError, match=r"block\[1\]: must stand on its axis"):
        leaning.across()


@pytest.mark.parametrize("slip", [-0.2, 0.0, 0.2])
@pytest.mark.parametrize("slope", [-1e-3, 1e-3])
@pytest.mark.parametrize("strips", [None, (0.0, 0.0, 1.0, 1.0, 1.0)])
def test_the_opening_is_the_gap_at_the_far_end_of_the_contact(
    slip: float, slope: float, strips: tuple[float, ...] | None
) -> None:
    """Turn a block of 1 m about an end of its contact: the gap is the slope times the length of the contact.

    Strips touch from -0.1 to 0.5 m: the gap was 0.4 or 0.8 mm, by the side, in place of 0.6 mm. After a slip the block
    below, as wide, cuts the contact off. Measured: 4e-8 of the gap.
    """
    joint = Joint(1e9, 1e-3, friction=0.5)
    over = joint if strips is None else replace(joint, section="strips", width=1.0, strips=strips)
    column = Column("two", (Block(2.0, 1.0, 1.0, 5000.0, over), Block(2.0, 1.0, 1.0, 5000.0, joint)), Settings())
    left, right = max(-0.5 if strips is None else -0.1, -0.5 - slip), min(0.5, 0.5 - slip)
    # the end about which the block turns, in the middle between both faces, stays in touch
    opening = slope * ((right if slope > 0.0 else left) + 0.5 * slip)
    phase = np.array([slope, 0.0, opening, 0.0, *np.zeros(4), slip, 0.0, 0.0, 0.0])
    assert chain_of(column).gaps(phase)[0] == pytest.approx((right - left) * abs(slope), rel=1e-6)


def test_a_structure_is_not_read_as_a_column() -> None:
    structure = EXAMPLES.parent / "structures" / "trilith.toml"
    with pytest.raises(
        InputError, match=r"trilith\.toml: is a structure in space, must be a column: Structure\.from_toml"
    ):
        Column.from_toml(structure)
