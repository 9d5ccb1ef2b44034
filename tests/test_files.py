"""A file that is being written is there whole or not at all, whatever happens in between."""

from __future__ import annotations

import os
import subprocess
import zipfile
from pathlib import Path

import pytest
from child import command, ended
from fmus import ROOT, environment
from inside import full_disk

from solver import Motion
from solver.files import whole_file

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
