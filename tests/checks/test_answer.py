"""Sentences of a check against its rows and verdicts, which are made at random: none may be false of any of them."""

import math
import re

import numpy as np
import pytest

from solver.checks.answer import answer, margin_sentence, verdict_sentence
from solver.checks.limits import Limits
from solver.checks.margin import Margin
from solver.checks.table import MM, Row, overturning
from solver.checks.verdicts import Verdicts

CASES = 300
WORDS = ("standing", "overturned", "undecided", "unfinished")


def random_verdicts(rng: np.random.Generator) -> Verdicts:
    """Return verdicts of 1 to 8 motions, and of one to five varied runs of each; often of one kind alone."""
    motions, each = int(rng.integers(1, 9)), int(rng.integers(1, 6))
    odds = rng.dirichlet([2.0, 0.2, 0.2, 0.1])
    own_odds = rng.dirichlet([2.0, 0.2, 0.2])
    names = [f"artificial {k}" for k in range(motions)]
    own = rng.choice(WORDS[:3], motions, p=own_odds)  # a check ends if a run as given cannot be finished
    return Verdicts(names, own, rng.choice(WORDS, motions * each, p=odds))


def random_margin(rng: np.random.Generator, found: Verdicts) -> Margin | None:
    """Return a margin as `margin_of` does: below 1 where a run falls at 1, else not."""
    if rng.random() < 0.2:
        return None
    place = int(rng.integers(len(found.names)))
    if found.falls_by_motion.any():
        low = float(rng.choice([0.0, rng.uniform(0.05, 0.97)]))
        return Margin(low, low * 1.03 if low else 0.07, place)
    low = rng.uniform(1.0, 2.7)
    return Margin(3.84, math.inf, -1) if rng.random() < 0.3 else Margin(low, low * 1.03, place)


def random_rows(rng: np.random.Generator, found: Verdicts) -> list[Row]:
    """Return rows of demands: infinite where the model falls, some without a capacity."""
    falls = bool(found.own_falls)
    return [
        Row(name, math.inf if falls else float(rng.uniform(0.0, 1.3)), float(rng.choice([1.0, math.nan])), MM)
        for name in ("displacement of the top", "pressure at the edge", "slip")
    ]


@pytest.mark.long  # takes 10 s and more
def test_no_sentence_is_false_of_a_row() -> None:
    for seed in range(CASES):
        check_sentences(np.random.default_rng(seed))


def check_sentences(rng: np.random.Generator) -> None:
    found = random_verdicts(rng)
    margin = random_margin(rng, found)
    limits = Limits(share=float(rng.choice([0.0, 0.1])))
    rows = [*overturning(found, limits, margin, {}), *random_rows(rng, found)]
    by_name = {row.name: row for row in rows}

    said = answer(rows)
    failed = [row.name for row in rows if row.passes is False]
    left = by_name["undecided"].undecided if "undecided" in by_name else False
    assert said.startswith("FAILS by: ") is bool(failed)
    assert said.startswith("UNDECIDED: ") is (left and not failed)
    assert said.startswith("PASSES: ") is (not left and not failed)
    if failed:
        named = re.fullmatch(r"FAILS by: (.*)\.", said)[1].split("; ")  # type: ignore[index]
        assert named == [name for name in failed if not math.isinf(by_name[name].demand)]
    if "overturned" in found.own:  # it counts first, whatever the varied runs do
        assert failed[0] == "overturning, as given"
        assert "displacement of the top" in failed or math.isnan(by_name["displacement of the top"].capacity)

    sentence = verdict_sentence("column", found)
    given, varied = sentence.split(". ", 1)
    own = dict(zip(found.names, found.own, strict=True))
    stands = all(verdict == "standing" for verdict in own.values())
    assert ("stands under" in given) is stands
    for verdict, words in (("overturned", "falls under"), ("undecided", "is undecided under")):
        named = [name for name, word in own.items() if word == verdict]
        assert (words in given) is bool(named)
        part = re.search(rf"{words} (\d+ of \d+ motions|artificial \d+(?: and artificial \d+)*)", given)
        if named and part:
            many = f"{len(named)} of {len(own)} motions"
            assert part[1].split(" and ") == named or (len(named) > 3 and part[1] == many)
    count = int(np.sum(np.isin(found.varied, ("overturned", "unfinished"))))
    undecided = int(np.sum(found.varied == "undecided"))
    size = len(found.varied)
    assert varied.startswith(f"{count or 'None'} of {size} varied columns fell")
    assert (f" and {undecided} may fall" in varied) is (undecided > 0)
    assert by_name["overturning"].note.startswith(f"{count} of {size} runs fall")
    assert by_name["overturning"].demand == pytest.approx(count / size)
    assert ("undecided" in by_name) is bool(undecided or "undecided" in found.own)
    low, high = found.bounds
    assert 0.0 <= low <= count / size <= high <= 1.0

    grows = margin_sentence(margin, undecided > 0)
    fell = count > 0 or "overturned" in found.own
    if margin is not None:
        assert ("can grow" in grows or "Even" in grows) is not fell
        allowed = 0 < count <= limits.share * size and "overturned" not in found.own
        assert by_name["overturning, margin"].passes is (None if allowed else not fell)
        assert ("do not count" in grows) is (undecided > 0)
    else:
        assert "overturning, margin" not in by_name
        assert "not looked for" in grows


def test_a_model_that_falls_itself_fails_though_no_varied_one_does() -> None:
    found = Verdicts(["artificial 0", "artificial 5"], np.array(["standing", "overturned"]), np.array(["standing"] * 4))
    rows = overturning(found, Limits(), Margin(0.96, 1.0, 1), {})
    assert answer(rows) == "FAILS by: overturning, as given; overturning, margin."
    assert verdict_sentence("column", found).startswith(
        "As given the column falls under artificial 5. None of 4 varied columns fell, under 2 motions: "
    )
    assert margin_sentence(Margin(0.96, 1.0, 1), False) == (
        "With the shaking reduced to about 0.96 of this none of them falls."
    )
    assert "none" not in rows[0].note
