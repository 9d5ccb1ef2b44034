"""Objects and mounts of a gallery: their files, mistakes in them, and the structures made of them."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.fmus import ROOT

from multiblock import InputError
from solver.checks.subject import subject_of
from solver.gallery.mounts import GRAVITY, Mount, mounted, read_mounts
from solver.gallery.objects import Exhibit, read_objects

HEAD = "name,material,width,depth,height,mass,centroid,mesh,pedestal,pedestal_width,pedestal_depth,pedestal_height"
HEAD += ",pedestal_mass,floor"
BOX = {"width": 0.4, "depth": 0.3, "height": 1.5, "mass": 300.0, "centroid": 0.6}
PEDESTAL = {"width": 0.6, "depth": 0.5, "height": 0.8, "mass": 500.0}
KORE = Exhibit("Kore", "marble", BOX, "", PEDESTAL, False, 0)
MESH = Exhibit("statue", "marble", {}, str(ROOT / "examples" / "structures" / "statue.obj"), PEDESTAL, False, 0)
SLAB = {"beyond": 0.2, "height": 0.1, "density": 2500.0}
RUBBER = {"kind": "elastomeric", "period": 2.0, "damping_ratio": 0.15, "diameter": 0.1, "capacity": 0.3}
RUBBER |= {"vertical_period": 0.05, "vertical_damping": 1e-3, "tension": True}


@pytest.mark.parametrize(
    ("row", "said"),
    [
        ("Kore,marbel,0.4,0.3,1.5,300,0.6,,,,,,,", "line 2: material = 'marbel': must be one of marble"),
        ("Kore,marble,0.4,0.3,1.5,3oo,0.6,,,,,,,", "line 2: mass = 3oo: must be a mass in kg"),
        ('Kore,marble,"0,4",0.3,1.5,300,0.6,,,,,,,', "must be 0.4 with a decimal point"),
        ("Kore,marble,400,0.3,1.5,300,0.6,,,,,,,", "line 2: width = 400.0: must be a length in m, from 0.001 to 30"),
        ("Kore,marble,0.4,0.3,1.5,300,1.6,,,,,,,", "line 2: centroid = 1.6: must be less than the height, 1.5 m"),
        ("Kore,marble,0.4,0.3,1.5,,0.6,,,,,,,", "line 2: mass: missing, must be a mass in kg"),
        ("Kore,marble,0.4,,,,,a.obj,,,,,,", "line 2: width = 0.4: must be left out, the mesh has it"),
        ("Kore,marble,0.4,0.3,1.5,300,0.6,,loose,0.6,0.5,0.8,500,", "pedestal = 'loose': must be one of free, fixed"),
        ("Kore,marble,0.4,0.3,1.5,300,0.6,,free,0.6,0.5,0.8,,", "line 2: pedestal_mass: missing, must be a mass"),
        ("Kore,marble,0.4,0.3,1.5,300,0.6,,free,0.3,0.5,0.8,500,", "width = 0.4: must be at most that of the pedestal"),
        ("Kore,marble,0.4,0.3,1.5,300,0.6,,,,,,,up", "line 2: floor = 'up': must be the number of a floor"),
        ("Kore,marble,0.4", "line 2: 3 values, must be 14 as in the header"),
        ("Ko/re,marble,0.4,0.3,1.5,300,0.6,,,,,,,", "line 2: name = 'Ko/re': must be a file name"),
    ],
)
def test_mistakes_name_line_column_and_what_is_right(row: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / "objects.csv"
    path.write_text(f"{HEAD}\n{row}\n", encoding="utf-8")
    with pytest.raises(InputError) as error:
        read_objects(path, 0)
    assert str(error.value).startswith(f"{path}: ")
    assert said in str(error.value)


def test_headings_and_names_are_checked(tmp_path: Path) -> None:
    path = tmp_path / "objects.csv"
    for text, said in (
        ("name,material,widht\n", "line 1: widht: unknown key, must be one of name"),
        ("name,width\nKore,1\n", "line 1: name, material: must be there once"),
        ("name,material,name\n", "line 1: name: must be there once"),
        ("name,material\n", "must have a line for each object"),
    ):
        path.write_text(text, encoding="utf-8")
        with pytest.raises(InputError, match=said):
            read_objects(path, 0)
    box = "marble,0.4,0.3,1.5,300,0.6,,,,,,,"
    path.write_text(f"{HEAD}\nKore,{box}\nKore,{box}\n", encoding="utf-8")
    with pytest.raises(InputError, match="line 3: name = Kore: must be another name"):
        read_objects(path, 0)


def test_mistakes_in_mounts_name_the_key(tmp_path: Path) -> None:
    path = tmp_path / "mounts.toml"
    for text, said in (
        ('[[mount]]\nname = "a"\nfeet = 2.0\n', r"mount\[1\]\.feet: unknown key"),
        ('[[mount]]\nname = "a"\nfoot = 0.5\n', r"mount\[1\]\.foot = 0\.5: must be a factor from 1 to 10"),
        ('[[mount]]\nname = "a"\n[[mount]]\nname = "a"\n', r"mount\[2\]\.name = a: must be another name"),
        ('[[mount]]\nname = "a"\nslab = { height = 0.1 }\n', r"slab and bearing must be given together"),
        ('[[mount]]\nname = "a"\ntie = 3\n', r"mount\[1\]\.tie = 3: must be a table"),
    ):
        path.write_text(text, encoding="utf-8")
        with pytest.raises(InputError, match=said):
            read_mounts(path)
    with pytest.raises(InputError, match=r"Kore on mount a: .*block\[2\].joint.friktion: unknown key"):
        mounted(KORE, Mount("a", joint={"friktion": 1.0}))
    with pytest.raises(InputError, match=r"tie\.length = None: must be a positive length"):
        mounted(KORE, Mount("a", tie={"stiffness": 1e7}))
    with pytest.raises(InputError, match=r"slab\.beyond = None: must be a length in m, from 0 to 10"):
        mounted(KORE, Mount("a", slab={"height": 0.1}, bearing=RUBBER))
    with pytest.raises(InputError, match=r"makes 0\.8 x 0\.6 m, must fit on the pedestal, 0\.6 x 0\.5 m"):
        mounted(KORE, Mount("a", foot=2.0))


def test_the_example_makes_structures_with_the_given_masses_and_centroids() -> None:
    exhibits = read_objects(ROOT / "examples" / "gallery" / "objects.csv", 0)
    mounts = read_mounts(ROOT / "examples" / "gallery" / "mounts.toml")
    assert len(exhibits) == 6
    for exhibit in exhibits:
        for mount in mounts:
            made = mounted(exhibit, mount)
            block = made.blocks[-1]
            if exhibit.box:
                assert block.mass == exhibit.box["mass"]
                foot = made.joints[made.joint_names.index(next(n for n in made.joint_names if "object" in n))].face
                assert block.centroid[2] - foot.centre[2] == pytest.approx(exhibit.box["centroid"], abs=1e-12)
            stands_alone = not exhibit.pedestal or exhibit.fixed
            assert made.n == (1 if stands_alone and not mount.bearing else 2)


def test_a_pedestal_and_its_slab_are_one_block() -> None:
    made = mounted(KORE, Mount("rubber", slab=SLAB, bearing=RUBBER)).blocks[0]
    assert made.mass == pytest.approx(500.0 + 2500.0 * 1.0 * 0.9 * 0.1)
    np.testing.assert_allclose(np.ptp(made.corners, axis=0), [1.0, 0.9, 0.9])
    top = next(face for face in made.faces if face.normal[2] > 0.9)
    np.testing.assert_allclose(np.ptp(top.outline, axis=0), [0.6, 0.5])
    # a factor on the pedestal widens its top, and the slab with it
    made = mounted(KORE, Mount("rubber", foot=1.6, pedestal=1.5, slab=SLAB, bearing=RUBBER)).blocks[0]
    assert made.mass == pytest.approx(500.0 + 2500.0 * 1.3 * 1.15 * 0.1)
    np.testing.assert_allclose(np.ptp(made.corners, axis=0), [1.3, 1.15, 0.9])
    top = next(face for face in made.faces if face.normal[2] > 0.9)
    np.testing.assert_allclose(np.ptp(top.outline, axis=0), [0.9, 0.75])


@pytest.mark.parametrize(
    ("exhibit", "slab", "said"),
    [
        (KORE, True, "makes 0.96 x 0.72 m, must fit on the pedestal, 0.9 x 0.75 m"),
        (KORE, False, "makes 0.96 x 0.72 m, must fit on the pedestal, 0.9 x 0.75 m"),
        (replace(KORE, fixed=True), False, "makes 0.96 x 0.72 m, must fit on the pedestal, 0.9 x 0.75 m"),
        (replace(KORE, pedestal={}), True, "makes 0.96 x 0.72 m, must fit on the slab, 0.8 x 0.7 m"),
        (replace(MESH, pedestal=PEDESTAL), False, "makes 1.344 x 1.152 m, must fit on the pedestal, 0.9 x 0.75 m"),
    ],
)
def test_a_foot_that_overhangs_is_refused(exhibit: Exhibit, slab: bool, said: str) -> None:
    mount = Mount("wide", foot=2.4, pedestal=1.5)
    if slab:
        mount = replace(mount, slab=SLAB, bearing=RUBBER)
    with pytest.raises(InputError, match=f"on mount wide: foot = 2.4: {said}"):
        mounted(exhibit, mount)


def test_bearings_have_the_periods_of_the_mount() -> None:
    made = mounted(KORE, Mount("rubber", slab=SLAB, bearing=RUBBER))
    mass = sum(block.mass for block in made.blocks)
    stiffness = sum(joint.bearing.spring for joint in made.bearings if joint.bearing)
    dashpots = sum(joint.bearing.dashpot for joint in made.bearings if joint.bearing)
    assert 2.0 * math.pi * math.sqrt(mass / stiffness) == pytest.approx(2.0)
    assert dashpots / (2.0 * math.sqrt(mass * stiffness)) == pytest.approx(0.15)
    # the whole structure: rubber that gives way upwards makes it rock a little too; measured 0.4 % longer
    assert subject_of(made).period == pytest.approx(2.0, rel=0.01)
    pendulum = RUBBER | {"kind": "pendulum", "friction": 0.05, "initial_period": 0.2}
    pendulum = {key: value for key, value in pendulum.items() if key not in ("damping_ratio", "tension")}
    found = mounted(KORE, Mount("pendulums", slab=SLAB, bearing=pendulum)).bearings[0].bearing
    assert found is not None
    assert 1.0 / found.pendulum == pytest.approx(GRAVITY / math.pi**2)


def test_a_wider_foot_and_a_tie_are_where_they_should_be() -> None:
    joint = mounted(KORE, Mount("wide", foot=1.4)).joints[-1]
    np.testing.assert_allclose(np.ptp(joint.face.outline, axis=0), [0.56, 0.42])
    held = mounted(KORE, Mount("dowel", tie={"length": 0.2, "stiffness": 1e7, "yield": 1e3}))
    (tie,) = held.ties
    ends = held.blocks[tie.one].centroid + tie.from_, held.blocks[tie.other].centroid + tie.to
    np.testing.assert_allclose(ends, [[0.0, 0.0, 0.9], [0.0, 0.0, 0.7]], atol=1e-12)


@pytest.mark.parametrize("pedestal", [PEDESTAL, {}])
def test_the_pin_of_a_mesh_is_upright_in_the_middle_of_its_foot(pedestal: dict[str, float]) -> None:
    """Check a statue whose centroid is 12.5 and 3.5 mm beside the middle: its pin leaned by 3.7 degrees."""
    held = mounted(replace(MESH, pedestal=pedestal), Mount("dowel", tie={"length": 0.2, "stiffness": 1e7}))
    (tie,), level = held.ties, pedestal.get("height", 0.0)
    assert np.all(np.abs(held.blocks[-1].centroid[:2]) > 3e-3)
    below = held.blocks[0].centroid if pedestal else 0.0
    ends = held.blocks[tie.one].centroid + tie.from_, below + tie.to
    np.testing.assert_allclose(ends, [[0.0, 0.0, level + 0.1], [0.0, 0.0, level - 0.1]], atol=1e-12)
