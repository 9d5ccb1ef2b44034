"""The command `check`: its table, its files, and its answers to mistakes."""

import os
import tomllib
from pathlib import Path

import numpy as np
import pytest

from multiblock import Building, Column, InputError, Motion, check, simulate, spectra
from solver.checks.action import Level, action_on
from solver.checks.spectra import CornerSpectrum, TargetSpectrum
from solver.checks.subject import subject_of
from solver.commands.code_spectra import CODES, Code, Option
from solver.commands.command_line import main

G = 9.80665
COLUMN = """name = "block"
[[block]]
height = 2.0
width = 0.5
depth = 0.5
mass = 1200.0
joint = { stiffness = 2e9, damping = 2e-3, strength = 2e6 }
"""
QUICK = ("--no-margin", "--no-joints", "--ensemble", "1")
HALL = "[building]\nstoreys = 3\nperiod = 0.4\nalpha = 2.0\nperiod_y = 0.3\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a column, a wider one, and two records, in the current folder."""
    monkeypatch.chdir(tmp_path)
    Path("block.toml").write_text(COLUMN, encoding="utf-8")
    wider = COLUMN.replace('"block"', '"wider"').replace("width = 0.5", "width = 1.0").replace("1200", "2400")
    Path("wider.toml").write_text(wider, encoding="utf-8")
    time = np.arange(0.0, 3.0, 0.01)
    for name, frequency in (("slow", 1.0), ("fast", 2.5)):
        Motion.from_samples(0.01, np.sin(2.0 * np.pi * frequency * time)).to_csv(f"{name}.csv")
    return tmp_path


@pytest.mark.long  # takes seconds
def test_check_prints_tables_variants_and_writes(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["check", "block.toml", "--pga", "0.1", *QUICK, "--variant", "wider.toml"]
    report = ["--report", "report.html", "--note", "Museum <North>, hall 3", "--note", "checked 1 May"]
    assert main([*words, "-o", "table.csv", *report, "slow.csv", "fast.csv"]) == 0
    printed = capsys.readouterr().out
    assert "each to a largest horizontal acceleration of 0.1 g; counted: largest of 2 motions" in printed
    assert "None of 2 varied columns fell" in printed
    variants = printed[printed.index("variants under the same motions") :]
    assert variants.splitlines()[1].split() == ["block", "wider"]
    for name in ("overturning", "displacement of the top", "pressure at the edge"):
        assert name in variants
    assert {line.split(",")[0] for line in Path("table.csv").read_text().splitlines()} == {"model", "block", "wider"}
    page = Path("report.html").read_text(encoding="utf-8")
    assert "SHA-256" in page
    assert page.count("<h2>The column</h2>") == page.count("<h2>Variant: wider</h2>") == 1
    assert '<p class="note">Museum &lt;North&gt;, hall 3</p>' in page
    assert '<p class="note">checked 1 May</p>' in page
    assert main([*words, "slow.csv", "-o", "table.csv"]) == 2
    assert "table.csv: is there already, --force overwrites it" in capsys.readouterr().err


def test_components_and_a_table_of_a_spectrum(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("site.csv").write_text("period,g\n0.01,0.05\n4,0.04\n", encoding="utf-8")
    words = ["check", "block.toml", "slow.csv", "--vertical", "fast.csv", "--spectrum", "site.csv"]
    assert main([*words, "--periods", "0.1", "1", *QUICK]) == 0
    printed = capsys.readouterr().out
    assert "action: site.csv" in printed
    assert "vertical fast.csv: CSV" in printed


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--spectrum", "ec8", "--ag", "0.2"], "--soil: must be given with --spectrum ec8"),
        (["--spectrum", "ec9"], f"--spectrum ec9: must be {', '.join(CODES)} or a table FILE.csv"),
        (
            ["--spectrum", "EC8", "--ag", "0.2", "--soil", "A"],
            f"--spectrum EC8: must be {', '.join(CODES)} or a table FILE.csv; did you mean ec8?",
        ),
        (
            ["--spectrum", "ec8", "--ag", "25", "--soil", "A"],
            "--ag = 25.0: must be an acceleration in g",
        ),
        (["--spectrum", "ec8", "--ag", "0", "--soil", "A"], "--ag = 0.0: must be an acceleration in g, from 0.001"),
        (["--pga", "0.2", "--soil", "A"], f"--soil A: is for --spectrum {' or '.join(CODES)}"),
        (["--limit", "slope=1"], "--limit slope=1: must be KEY=VALUE with one of displacement, friction"),
        (["--limit", "hits=0.1"], "limits.hits: must be left out, nothing has neighbours"),
        (["--limit", "overlap=0.1"], "limits.overlap: must be left out, in the plane no blocks overlap"),
        (["--space", "--limit", "displacement=0.1"], "limits.displacement: must be left out, in space a displacement"),
        (["--limit", "residual=0.1"], "limits.residual: must be left out, no joint has friction"),
        (["--limit", "slip=wide"], "--limit slip=wide: must be slip= and a number"),
        (["--vertical", "fast.csv", "slow.csv"], "--vertical: 2 files, must be 1, one for each record"),
        (["slow.csv"], "slow.csv: is given twice, must be given once"),
        (["--report", "report.pdf"], "report.pdf: must end in .html or .htm"),
        (["--note", "hall 3"], "--note: is for the report, must be given with --report FILE.html"),
    ],
)
def test_mistakes_are_one_line(
    folder: Path, capsys: pytest.CaptureFixture[str], words: list[str], message: str
) -> None:
    assert main(["check", "block.toml", "slow.csv", *words]) == 2
    errors = capsys.readouterr().err
    assert message in errors
    assert errors.count("\n") == 1


def test_a_variant_that_stays_in_its_plane_is_refused_before_any_run(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("leaning.toml").write_text(COLUMN.replace('"block"', '"leaning"') + "tilt = 0.01\n", encoding="utf-8")
    words = ["check", "block.toml", "--variant", "leaning.toml", *QUICK, "--artificial", "1"]
    words += ["--spectrum", "ec8", "--ag", "0.02", "--soil", "A"]
    assert main(words) == 2
    printed = capsys.readouterr()
    assert "variant leaning: moves in its plane, but the motions have two horizontal components: must be" in printed.err
    assert printed.err.count("\n") == 1
    assert "first period" not in printed.out
    assert main([*words, "--plane"]) == 0  # as the message says


def test_no_record_needs_a_spectrum(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", "block.toml", *QUICK]) == 2
    assert "motions: none given, must be records, or a target spectrum" in capsys.readouterr().err


def test_a_row_is_enough_for_another_code(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Check an option of its own, without those of the others: the parser, the help and the messages follow."""

    def plateau(top: float) -> TargetSpectrum:
        return TargetSpectrum("flat", CornerSpectrum(0.4 * top, 2.5, 0.1, 0.5, 2.0))

    top = Option("plateau", float, "G", "of the spectrum, g", "top", G)
    monkeypatch.setitem(CODES, "flat", Code(plateau, (top,)))
    words = ["check", "block.toml", "slow.csv", *QUICK, "--periods", "0.1", "1", "--spectrum"]
    assert main([*words, "flat", "--plateau", "0.3"]) == 0
    assert "action: flat" in capsys.readouterr().out
    assert main([*words, "ec8", "--ag", "0.05", "--soil", "A"]) == 0
    for given, message in (
        (["flat"], "--plateau: must be given with --spectrum flat"),
        (["flat", "--plateau", "1", "--soil", "A"], "--soil A: is for --spectrum ec8 or ntc2018"),
        (["ec8", "--ag", "0.2", "--soil", "A", "--plateau", "1"], "--plateau 1.0: is for --spectrum flat"),
        (["ec9"], "--spectrum ec9: must be ec8, ntc2018, flat or a table FILE.csv"),
    ):
        assert main([*words, *given]) == 2
        assert message in capsys.readouterr().err
    with pytest.raises(SystemExit):
        main(["check", "--help"])
    assert "of flat: of the spectrum, g" in capsys.readouterr().out


@pytest.mark.long  # takes seconds
def test_odd_names_reach_neither_terminal_nor_legend_as_they_are(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Check names of records: no UTF-8, a control code, a formula of matplotlib, a name that legends leave out."""
    names = [os.fsdecode(b"caf\xe9.csv"), "\x1b[31mred.csv", "$x_$^{.csv", "_hidden.csv"]
    for name in names:
        Path(name).write_bytes(Path("slow.csv").read_bytes())
    words = ["check", "block.toml", *names, "--pga", "0.05", *QUICK, "--note", os.fsdecode(b"by caf\xe9")]
    assert main([*words, "-o", "table.csv", "--report", "report.html"]) == 0
    printed = capsys.readouterr().out
    assert "\x1b" not in printed
    for shown in (r"caf\udce9", r"\x1b[31mred", "$x_$^{", "_hidden"):
        assert shown in printed
        assert shown in Path("table.csv").read_text(encoding="utf-8")
        assert shown in Path("report.html").read_text(encoding="utf-8")
    assert main(["check", "block.toml", "\x1b[31mnone.csv"]) == 2
    assert r"\x1b[31mnone.csv" in capsys.readouterr().err


def test_a_record_in_other_units_and_a_factor_out_of_range(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    time = np.arange(0.0, 1.0, 0.01)
    Motion.from_samples(0.01, 320.0 * np.sin(2.0 * np.pi * time)).to_csv("gal.csv")
    assert main(["check", "block.toml", "gal.csv", "--pga", "0.05", *QUICK]) == 2
    assert "--force-scale" in capsys.readouterr().err
    assert main(["check", "block.toml", "gal.csv", "--pga", "0.05", "--force-scale", *QUICK]) == 0
    assert "warning: gal.csv: largest acceleration 32.63 g, ground motions reach 3 g" in capsys.readouterr().err
    for factor in ("-1", "nan", "0", "1e300"):
        for space in ([], ["--space"]):
            assert main(["check", "block.toml", "slow.csv", "--confidence-factor", factor, *space, *QUICK]) == 2
            assert "must be a confidence factor from 1 to 3" in capsys.readouterr().err


@pytest.mark.long  # takes seconds
def test_both_directions_in_one_command(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Check that the second is the column with width and depth exchanged; the report has both answers."""
    deep = COLUMN.replace("depth = 0.5", "depth = 1.0")
    Path("deep.toml").write_text(deep, encoding="utf-8")
    Path("turned.toml").write_text(COLUMN.replace("width = 0.5", "width = 1.0"), encoding="utf-8")
    words = ["slow.csv", "--pga", "0.3", *QUICK]
    assert main(["check", "deep.toml", *words, "--both", "--report", "report.html"]) == 0
    printed = capsys.readouterr().out
    assert "check the other direction too" not in printed
    answers = [line for line in printed.splitlines() if line.startswith(("block: ", "block across: "))]
    assert [line.partition(":")[2].split()[0] for line in answers] == ["FAILS", "PASSES:"]
    assert "block across: PASSES" in Path("report.html").read_text(encoding="utf-8")
    tables = printed.split("first period")
    assert main(["check", "turned.toml", *words, "--periods", "0.1", "1"][:-3]) == 0
    turned = capsys.readouterr().out.split("first period")[1]
    assert turned.splitlines()[3:8] == tables[2].splitlines()[3:8]  # all of the rows, from the margin left out on
    assert main(["check", "block.toml", *words, "--both"]) == 2
    assert "--both: must be left out, block.toml is the same in both directions" in capsys.readouterr().err


@pytest.mark.long  # takes 10 s and more
def test_mortar_is_said_wherever_it_is_left_out(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Check statics, checks that compare with the dry edge, and the report; and which joint broke through."""
    mortar = COLUMN.replace("strength = 2e6 }", "friction = 0.6, tensile_strength = 2e5, cohesion = 3e5 }")
    Path("mortar.toml").write_text(mortar, encoding="utf-8")
    said = "computed without mortar, as once all bonds have broken"
    for file, counted in (("mortar.toml", 1), ("block.toml", 0)):
        assert main(["statics", file]) == 0
        assert capsys.readouterr().out.count(said) == counted
    for pga, broken in (("0.05", 0.0), ("0.5", 1.0)):
        words = ["check", "mortar.toml", "slow.csv", "--pga", pga, *QUICK, "--report", "report.html", "--force"]
        assert main(words) == 0
        printed = capsys.readouterr().out
        run = simulate(Column.from_toml("mortar.toml"), Motion.from_file("slow.csv").scaled_to(float(pga) * G))
        assert 1.0 - run.peaks["bond"][0] == broken
        through = "Its mortar breaks through as given: joint 1 (under 1 of 1 motions)"
        assert (through in printed) == bool(broken)
        assert ("No joint of mortar breaks through." in printed) == (not broken)
        page = Path("report.html").read_text(encoding="utf-8")
        for text in (printed, page):
            assert f"The displacement at which it balances on its edge, and the methods by hand, are {said}." in text
            assert (through in text) == bool(broken)
        for text in ("tensile strength (MPa)", "cohesion (MPa)", "0.2", "0.3", "until their mortar breaks"):
            assert text in page
        assert "The joints bear pressure only" not in page


@pytest.mark.long  # takes 10 s and more
def test_two_components_act_unless_the_plane_is_asked_for(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Check a code spectrum, and records with --across; one record alone, --plane and --both keep the plane."""
    code = ["--spectrum", "ec8", "--ag", "0.02", "--soil", "A", "--artificial", "1"]
    deep = COLUMN.replace("depth = 0.5", "depth = 1.0")
    Path("deep.toml").write_text(deep, encoding="utf-8")
    Path("offset.toml").write_text(COLUMN.replace("joint = {", "joint = { offset = 0.01,"), encoding="utf-8")
    two, one = "Two horizontal components act together.", "One horizontal component acts; codes ask for two together"
    for words, said, kind in (
        (["block.toml", *code], two, "structures"),
        (["block.toml", "slow.csv", "--across", "fast.csv", "--pga", "0.05"], two, "structures"),
        (["block.toml", "slow.csv", "--space", "--pga", "0.05"], one, "structures"),
        (["block.toml", *code, "--plane"], one, "columns"),
        (["block.toml", "slow.csv", "--pga", "0.05"], one, "columns"),
        (["deep.toml", *code, "--both"], one, "columns"),
        (["offset.toml", *code], one, "columns"),
    ):
        assert main(["check", *words, *QUICK]) == 0
        printed = capsys.readouterr().out
        assert said in printed, words
        assert f"1 varied {kind}" in printed, words
        moved = "two horizontal components act, so it is checked in space; --plane keeps it in its plane" in printed
        assert moved == (said == two)
        assert ("to be stacked in space; checked in its plane" in printed) == (words[0] == "offset.toml")
    assert main(["check", "offset.toml", "slow.csv", "--across", "fast.csv", "--pga", "0.05", *QUICK]) == 2
    assert "must stand on its axis, and not on strips, to be stacked in space" in capsys.readouterr().err
    assert main(["check", "block.toml", "slow.csv", "--across", "fast.csv", "--pga", "0.05", *QUICK, "--plane"]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_both_directions_of_a_structure(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Check that the second check turns the motions: along its short side the block falls, along the other it
    stands.
    """
    block = 'name = "slab"\n[joints]\nstiffness = 2e9\ndamping = 2e-3\n[[block]]\nname = "slab"\non = "base"\n'
    Path("slab.toml").write_text(f"{block}width = 0.5\ndepth = 1.5\nheight = 2.0\nmass = 1200.0\n", encoding="utf-8")
    assert main(["check", "slab.toml", "slow.csv", "--pga", "0.4", *QUICK, "--both"]) == 0
    printed = capsys.readouterr().out
    peaks = [line.split()[2:] for line in printed.splitlines() if line.startswith("slow  ")]
    assert peaks[0][0] == peaks[1][1] == "0.4"  # PGA along x, then along y
    assert peaks[0][2] == peaks[1][4] != "0"  # PGV along x, then along y
    assert printed.count("One horizontal component acts; codes ask for two together") == 2
    answers = [line for line in printed.splitlines() if line.startswith(("slab: ", "slab across: "))]
    assert [line.partition(":")[2].split()[0] for line in answers] == ["FAILS", "PASSES:"]


@pytest.mark.long
def test_round_contacts_are_checked_in_space_unless_kept_in_the_plane(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    drum = COLUMN.replace("width = 0.5\ndepth = 0.5", 'section = "circle"\ndiameter = 0.5')
    Path("drum.toml").write_text(drum, encoding="utf-8")
    Path("soft.toml").write_text(drum.replace("joint = {", "joint = { offset = 0.01,"), encoding="utf-8")
    words = ["slow.csv", "--pga", "0.05", *QUICK]
    assert main(["check", "drum.toml", *words]) == 0
    printed = capsys.readouterr().out
    assert "drum.toml: its contacts are round and may roll, so it is checked in space" in printed
    assert "1 varied structures" in printed
    assert main(["check", "drum.toml", "--plane", *words]) == 0
    printed = capsys.readouterr().out
    assert "1 varied columns" in printed
    assert "in space they roll on their rims" in printed
    assert main(["check", "soft.toml", *words]) == 0
    printed = capsys.readouterr().out
    assert "soft.toml: block[1]: must stand on its axis, and not on strips, to be stacked in space; checked" in printed
    assert "1 varied columns" in printed
    assert "may fall under less than here.\n" in printed  # it cannot go there
    assert main(["check", "soft.toml", *words, "--both"]) == 2
    assert "to be turned to the other direction" in capsys.readouterr().err


def test_variants_of_one_name_are_named_by_their_files(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("wider.toml").write_text(COLUMN.replace("width = 0.5", "width = 1.0"), encoding="utf-8")
    (folder / "other").mkdir()
    (folder / "other" / "block.toml").write_text(COLUMN.replace("2e-3", "3e-3"), encoding="utf-8")
    words = ["check", "block.toml", "slow.csv", "--pga", "0.1", *QUICK]
    assert main([*words, "--variant", "wider.toml"]) == 0
    assert "wider (block[1].width 0.5 to 1) against block: " in capsys.readouterr().out
    assert main([*words, "--variant", "other/block.toml"]) == 0
    assert "block 2 (block[1].joint.damping 0.002 to 0.003) against block 1: " in capsys.readouterr().out


@pytest.mark.long  # takes seconds
def test_a_check_on_a_floor(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("hall.toml").write_text(HALL, encoding="utf-8")
    words = ["check", "block.toml", "slow.csv", "--pga", "0.1", *QUICK, "--building", "hall.toml"]
    assert main([*words, "--floor", "3", "--both", "--report", "report.html"]) == 2
    assert "--both" in capsys.readouterr().err  # it is alike across
    assert main([*words, "--floor", "3", "--report", "report.html"]) == 0
    printed = capsys.readouterr().out
    where = "floor 3 of 3 of hall, first period 0.4 s along x, 0.3 s along y"
    assert f"each to a largest horizontal acceleration of 0.1 g; on {where}; counted: one motion" in printed
    assert f"It stands on {where}. Factors and target are those of the ground" in printed
    assert where in Path("report.html").read_text(encoding="utf-8")
    assert main([*words, "--floor", "0"]) == 0
    ground = capsys.readouterr().out.splitlines()[-1]
    assert main(words[:-2]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == ground  # the same inputs
    assert main([*words, "--floor", "4"]) == 2
    assert "--floor = 4: must be a whole number from 0" in capsys.readouterr().err


def test_the_other_direction_has_the_other_period_of_the_building(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("hall.toml").write_text(HALL, encoding="utf-8")
    Path("deep.toml").write_text(COLUMN.replace("depth = 0.5", "depth = 0.6"), encoding="utf-8")
    words = ["check", "deep.toml", "slow.csv", "--pga", "0.05", *QUICK, "--both", "--building", "hall.toml"]
    assert main([*words, "--floor", "3", "--report", "report.html"]) == 0
    printed = capsys.readouterr().out
    page = Path("report.html").read_text(encoding="utf-8")
    assert "hall, first period 0.4 s along x, 0.3 s along y. Factors" in printed
    assert "hall across, first period 0.3 s along x, 0.4 s along y. Factors" in printed
    # each direction has its motions, whose peaks differ
    peaks = [line.split()[2] for line in printed.splitlines() if line.startswith("slow  ")]
    assert len(set(peaks)) == 2
    assert printed.index("block across:\naction: ") < printed.index("block across, first period")
    for name, peak in zip(("block", "block across"), peaks, strict=True):
        section = page[page.index(f"<h2>The motions of {name}</h2>") :].partition("</table>")[0]
        assert f'<td class="number">{peak}</td>' in section
    # and they are not called the same
    assert "the two directions, demand and its ratio to the capacity:" in printed
    assert "<h2>The two directions</h2>" in page
    assert "same motions" not in (printed + page).lower()


def test_a_target_is_that_of_the_ground() -> None:
    column, hall = Column.from_dict(tomllib.loads(COLUMN)), Building.beam(3, 0.4, 2.0)
    target = spectra.eurocode8(1.0, "B")
    subject = subject_of(column)
    level = Level(target, None, None, None, None, 0.9, 1, False, 0)
    ground = action_on(subject, (), level, building=hall)
    action = ground.on_floor(hall, 3)
    assert action.fit == ground.fit
    assert action.periods is not None
    assert action.periods[1] >= 0.8
    assert ground.spectrum is target
    assert action.spectrum.psa(0.4) > 2.0 * target.psa(0.4)  # that of the floor, not the target
    with pytest.raises(InputError, match="floor = 2: must be given with a building"):
        check(column, target=target, floor=2)


def test_a_floor_table_below_the_ground_is_said(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Compare a table that has 0.8 or 1.2 times the ordinates of the ground at long periods."""
    period = subject_of(Column.from_toml("block.toml")).longest
    ground = spectra.eurocode8(0.25 * G, "B")
    here = float(ground.psa(period)) / G
    periods = np.linspace(0.02, 4.0, 400)
    for size, is_said in ((0.8, True), (1.2, False)):
        values = np.where(periods < 1.0, 2.0, size * ground.psa(periods) / G)
        rows = "".join(f"{t},{value}\n" for t, value in zip(periods, values, strict=True))
        Path("floor.csv").write_text(f"period,g\n{rows}", encoding="utf-8")
        words = ["check", "block.toml", "slow.csv", "--spectrum", "floor.csv", "--plane", "--force-scale", *QUICK]
        assert main([*words, "--below", "ec8", "--ag", "0.25", "--soil", "B"]) == 0
        said = capsys.readouterr().out
        expected = f"floor.csv has {0.8 * here:.3g} g at the rocking period, {period:.3g} s, less than the {here:.3g} g"
        assert (expected in said) == is_said
    assert main([*words, "--below", "floor.csv"]) == 0  # itself
    assert "rocking period" not in capsys.readouterr().out
    for mistake, message in (
        (["--pga", "0.1", "--below", "ec8"], "--below: is for a table of a floor, must be given with --spectrum"),
        (["--spectrum", "floor.csv", "--below", "ec9"], "--below ec9: must be ec8, ntc2018 or a table FILE.csv"),
        (["--spectrum", "floor.csv", "--below", "ec8"], "--ag: must be given with --below ec8"),
        (["--spectrum", "floor.csv", "--ag", "0.2"], "--ag 0.2: is for --spectrum ec8 or ntc2018"),
    ):
        assert main(["check", "block.toml", "slow.csv", "--plane", *QUICK, *mistake]) == 2
        assert message in capsys.readouterr().err
