"""The journal of a study: whatever is in it was finished, whatever happens to the file or the process."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from solver import InputError
from solver.studies.journal import Journal, read_journal

HEAD = {"study": {"name": "first"}, "fingerprint": "abc", "versions": {"solver": "1"}}
ROWS = [[number, [0.1 * number, 1.0 / 3.0], ["text", None]] for number in range(5)]


def written(path: Path) -> bytes:
    with Journal(path, HEAD) as journal:
        journal.add(ROWS[:2])
        journal.add(ROWS[2:])
    return path.read_bytes()


def test_rows_come_back_to_the_last_bit(tmp_path: Path) -> None:
    path = tmp_path / "first.journal"
    written(path)
    head, rows = read_journal(path)
    assert list(rows) == ROWS
    assert {key: head[key] for key in HEAD} == HEAD
    with Journal(path, HEAD) as journal:
        assert journal.finished == {0, 1, 2, 3, 4}


def test_cut_off_anywhere_it_goes_on(tmp_path: Path) -> None:
    """Cut it off after every byte, as a killed process or a full disk leaves it."""
    path = tmp_path / "first.journal"
    whole = written(path)
    ends = [k for k, byte in enumerate(whole) if byte == ord("\n")]
    for length in range(len(whole) + 1):
        path.write_bytes(whole[:length])
        with Journal(path, HEAD) as journal:
            finished = sum(end < length for end in ends[1:])
            assert journal.finished == set(range(finished))
            journal.add(ROWS)
        assert path.read_bytes() == whole


def test_a_spoilt_line_is_made_again(tmp_path: Path) -> None:
    path = tmp_path / "first.journal"
    whole = written(path)
    path.write_bytes(whole.replace(b"[2,", b"[7,"))
    with Journal(path, HEAD) as journal:
        assert (journal.finished, journal.damaged) == ({0, 1, 3, 4}, 1)
        journal.add([ROWS[2]])
    assert sorted(read_journal(path)[1], key=lambda row: row[0]) == ROWS


def test_no_run_is_taken_twice(tmp_path: Path) -> None:
    path = tmp_path / "first.journal"
    whole = written(path)
    with Journal(path, HEAD) as journal:
        journal.add(ROWS)
    assert path.read_bytes() == whole


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"fingerprint": "abd"}, "holds another study, first"),
        ({"versions": {"solver": "2"}}, "was begun with solver 1, this is 2"),
    ],
)
def test_another_study_is_refused(tmp_path: Path, changed: dict[str, object], message: str) -> None:
    path = tmp_path / "first.journal"
    whole = written(path)
    with pytest.raises(InputError, match=message) as caught, Journal(path, {**HEAD, **changed}):
        pass
    assert str(caught.value).startswith(str(path))
    assert path.read_bytes() == whole


@pytest.mark.parametrize("content", ["a text\n", "a text", json.dumps(HEAD), "deadbeef [1]\n", "12345678 (none"])
def test_another_file_is_refused_and_kept(tmp_path: Path, content: str) -> None:
    path = tmp_path / "first.journal"
    path.write_text(content, encoding="utf-8")
    with pytest.raises(InputError, match="not the journal of a study"), Journal(path, HEAD):
        pass
    assert path.read_text(encoding="utf-8") == content
    with pytest.raises(InputError, match="not the journal of a study"):
        read_journal(path)


def test_one_at_a_time(tmp_path: Path) -> None:
    path = tmp_path / "first.journal"
    with Journal(path, HEAD) as journal:
        with pytest.raises(InputError, match="added to by another process"), Journal(path, HEAD):
            pass
        journal.add(ROWS)
        assert list(read_journal(path)[1]) == ROWS  # which may be read meanwhile


def test_a_folder_that_is_missing(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="No such file"), Journal(tmp_path / "none" / "first.journal", HEAD):
        pass
