"""A file that is being written is there whole or not at all, whatever happens in between."""

from __future__ import annotations

import os
import subprocess
import zipfile
from pathlib import Path

import pytest
from support.child import command, ended
from support.fmus import ROOT, environment
from support.inside import full_disk

from solver import Column, InputError, Motion
from solver.commands.command_line import main
from solver.common.errors import shortened, shown
from solver.common.files import MOST_RECORD, MOST_TOML, whole_file, write_table
from solver.studies import Study

COLUMN = ROOT / "examples" / "columns" / "phocas-damped.toml"


def test_the_previous_file_stays_until_the_new_one_is_whole(tmp_path: Path) -> None:
    path = tmp_path / "file.txt"
    path.write_text("before")

    def interrupted() -> None:
        with whole_file(path) as partial:
            partial.write_text("a part")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert path.read_text() == "before"
    with whole_file(path) as partial:
        partial.write_text("after")
        assert path.read_text() == "before"
    assert path.read_text() == "after"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.skipif(os.name == "nt", reason="Windows allows links to some users only")
def test_a_symbolic_link_stays(tmp_path: Path) -> None:
    """Write through a link to a file, and through one to a file that is not there yet."""
    (tmp_path / "store").mkdir()
    (tmp_path / "store" / "there.txt").write_text("before")
    for name in ("there.txt", "new.txt"):
        file, link = tmp_path / "store" / name, tmp_path / name
        link.symlink_to(file)
        with whole_file(link) as partial:
            partial.write_text("after")
        assert link.is_symlink()
        assert file.read_text() == "after"
    assert len(list(tmp_path.iterdir())) == 3


def test_errors_speak_of_the_file_that_was_asked_for(tmp_path: Path) -> None:
    path = tmp_path / "absent" / "file.txt"
    with pytest.raises(OSError, match=r"absent/file\.txt") as caught, whole_file(path) as partial:
        partial.write_text("a part")
    assert caught.value.filename == str(path)


def test_what_is_no_ordinary_file_is_written_to_as_it_is() -> None:
    with whole_file(os.devnull) as partial:
        assert str(partial) == os.devnull


@pytest.mark.skipif(os.name == "nt", reason="Windows has no limit on the size of files")
def test_a_full_disk_takes_nothing_away(tmp_path: Path) -> None:
    motion, response = tmp_path / "motion.csv", tmp_path / "response.csv"
    Motion.from_samples(1.0, [0.0, 0.1]).to_csv(motion)
    response.write_text("before")
    done = ended(full_disk.simulate, COLUMN, motion, response)
    assert done.returncode == 2
    assert done.stderr.strip() == f"python -m solver: {response}: File too large"
    assert sorted(tmp_path.iterdir()) == [motion, response]
    assert response.read_text() == "before"


READERS = {"a.toml": (Column.from_toml, MOST_TOML), "b.toml": (Study.from_toml, MOST_TOML)}
READERS |= {"c.AT2": (Motion.from_file, MOST_RECORD)}


@pytest.mark.parametrize("name", READERS)
def test_a_file_that_is_too_large_is_not_read(tmp_path: Path, name: str) -> None:
    """Refuse a sparse file, which takes no room on the disk."""
    path, (read, most) = tmp_path / name, READERS[name]
    with path.open("wb") as file:
        file.truncate(most + 1)
    with pytest.raises(InputError, match=rf"{name}: has {most / 1e6:.4g} MB, must have at most {most / 1e6:.4g} MB"):
        read(path)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="pipes with names are of POSIX")
@pytest.mark.parametrize("name", READERS)
def test_pipes_and_devices_are_refused_at_once(tmp_path: Path, name: str) -> None:
    """Refuse them without waiting, and without reading on and on."""
    os.mkfifo(tmp_path / name)
    os.symlink("/dev/zero", tmp_path / f"zero{name}")
    for path in (tmp_path / name, tmp_path / f"zero{name}"):
        with pytest.raises(InputError, match="is a pipe or a device, must be an ordinary file"):
            READERS[name][0](path)


def test_tables_nested_without_end_are_refused(tmp_path: Path) -> None:
    (tmp_path / "deep.toml").write_text("a = " + 50_000 * "[")
    with pytest.raises(InputError, match=r"deep\.toml: is nested too deeply"):
        Column.from_toml(tmp_path / "deep.toml")


@pytest.mark.parametrize(
    ("line", "output"),
    [
        ("convert motion.csv out.csv", "out.csv"),
        ("modes {column} -o out.csv", "out.csv"),
        ("statics {column} --plot out.png", "out.png"),
        ("calibrate {column} --damping-ratio 0.02 -o out.json", "out.json"),
        ("record motion.csv --plot out.png", "out.png"),
        ("simulate {column} motion.csv --settle 0 --no-check -o out.csv", "out.csv"),
    ],
)
def test_what_is_there_is_overwritten_by_force_only(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], line: str, output: str
) -> None:
    monkeypatch.chdir(tmp_path)
    Motion.from_samples(0.1, [0.0, 0.1, 0.0]).to_csv("motion.csv")
    Path(output).write_text("before")
    words = line.format(column=COLUMN).split()
    assert main(words) == 2
    assert capsys.readouterr().err == f"python -m solver: {output}: is there already, --force overwrites it\n"
    assert Path(output).read_text() == "before"
    assert main([*words, "--force"]) == 0
    assert Path(output).read_bytes() != b"before"


@pytest.mark.long
def test_two_builds_of_one_fmu_at_once(tmp_path: Path) -> None:
    output = tmp_path / "column.fmu"
    # without the machine code, which would be made twice
    one = command(full_disk.build_without_machine_code, COLUMN, output)
    builds = [
        subprocess.Popen(one, env=environment(), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        for _ in range(2)
    ]
    for build in builds:
        _, said = build.communicate()
        assert build.returncode == 0, said
    assert zipfile.ZipFile(output).testzip() is None
    assert list(tmp_path.iterdir()) == [output]


def test_a_text_that_spreadsheets_would_run_is_marked(tmp_path: Path) -> None:
    path = tmp_path / "table.csv"
    write_table(path, ["name", "=head"], [["=1+1", "-1.5"], ["@SUM(A1)", "+0.1"], ["plain", 2.0]])
    lines = path.read_text(encoding="utf-8").split()
    assert lines == ["name,'=head", "'=1+1,-1.5", "'@SUM(A1),+0.1", "plain,2.0"]


def test_what_messages_quote_is_short() -> None:
    assert shown(10**30) == str(10**30)
    assert shown(10**400) == "a whole number of about 400 digits"
    assert shown(10**5000) == "a whole number of about 5000 digits"  # which Python does not write
    assert len(shown([10**5000])) < 40
    assert shown(True) == "True"
    assert shortened(ValueError("could not convert\nmore")) == "could not convert"
    assert len(shortened(ValueError("1.0" + "9" * 5000))) < 200
