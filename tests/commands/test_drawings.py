"""The column is drawn where the response says that it is, and a film has as many pictures as it lasts."""

import math
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from matplotlib.animation import FFMpegWriter
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.image import imread
from matplotlib.text import Text
from PIL import Image
from support.probe import phocas

from solver import Block, Column, InputError, Joint, Motion, Response, simulate
from solver.ground.motion import STANDARD_GRAVITY
from solver.plotting.drawings import SHOWN, corners_of
from solver.statics.capacity import capacity_curve
from solver.statics.static_plots import spread


@pytest.fixture(scope="module")
def response() -> Response:
    return simulate(phocas(1e-3), Motion.harmonic(0.05 * STANDARD_GRAVITY, 2.0, 1.5))


@pytest.fixture(scope="module")
def falling() -> Response:
    """Return rotations of any size."""
    return simulate(phocas(1e-3), Motion.harmonic(0.6 * STANDARD_GRAVITY, 0.25, 3.0))


def at_peak(response: Response) -> int:
    return int(np.argmax(np.abs(response.ux[:, 0])))


@pytest.mark.parametrize("which", ["response", "falling"])
def test_blocks_are_where_the_response_has_them(which: str, request: pytest.FixtureRequest) -> None:
    response: Response = request.getfixturevalue(which)
    k = at_peak(response)
    height = 3 * 4.69
    for i, corners in enumerate(corners_of(response, k, 1.0)):
        turn = response.ry[k, i]
        left, right, top_right, top_left = corners
        assert 0.5 * (top_left + top_right)[0] == pytest.approx(response.ux[k, i], abs=1e-12)
        rest = height - (i + 0.5) * 4.69
        assert corners.mean(axis=0)[1] == pytest.approx(rest + response.uz[k, i], abs=1e-12)
        assert right - left == pytest.approx(1.56 * np.array([math.cos(turn), -math.sin(turn)]))
        assert top_left - left == pytest.approx(4.69 * np.array([math.sin(turn), math.cos(turn)]))


def test_the_scale_multiplies_rotations_and_openings(response: Response) -> None:
    k, scale = at_peak(response), 40.0
    drawn, true = corners_of(response, k, scale), corners_of(response, k, 1.0)

    def joint(corners: list[np.ndarray], i: int) -> np.ndarray:
        """Return the middle of the lower face of block i from the middle of the face below."""
        below = 0.5 * (corners[i + 1][2] + corners[i + 1][3]) if i < 2 else np.zeros(2)
        return 0.5 * (corners[i][0] + corners[i][1]) - below

    for i in range(3):
        assert np.hypot(*joint(drawn, i)) == pytest.approx(scale * np.hypot(*joint(true, i)), rel=1e-9)
        tall = drawn[i][3] - drawn[i][0]
        assert math.atan2(*tall) == pytest.approx(scale * response.ry[k, i])


def words(figure: Figure) -> list[str]:
    return [text.get_text() for text in (*figure.texts, *figure.axes[0].texts)]


def factor(figure: Figure) -> float:
    """Return the factor printed on a picture."""
    (text,) = [text for text in words(figure) if text.startswith("drawn ")]
    return 1.0 if text == "drawn to scale" else float(text.removeprefix("drawn ").removesuffix(" times larger"))


def test_the_deformed_column_states_its_time_and_scale(response: Response, tmp_path: Path) -> None:
    figure = response.plot_model(tmp_path / "column.png")
    k = at_peak(response)
    assert any(text.startswith(f"At {response.time[k]:.3f} s the top of block 1 is at") for text in words(figure))
    assert 0.4 * SHOWN * 14.07 < factor(figure) * np.max(np.abs(response.ux)) <= SHOWN * 14.07
    assert np.std(imread(tmp_path / "column.png")[..., :3]) > 0.05
    assert factor(response.plot_model(at=0.5, scale=7.0)) == 7.0
    assert any("At 0.500 s" in text for text in words(response.plot_model(at=0.5)))


def test_the_deformed_column_has_heights_numbers_and_a_scale_bar(response: Response) -> None:
    figure = response.plot_model()
    assert {"joint 1", "2", "3", "14.07 m"} <= set(words(figure))
    (text,) = [text for text in words(figure) if text.endswith("of motion")]
    lines = [np.array([line.get_xdata(), line.get_ydata()], dtype=float) for line in figure.axes[0].lines]
    (bar,) = [x for x, z in lines if np.all(z < 0.0)]
    assert text == f"{1e3 * np.ptp(bar) / factor(figure):.3g} mm of motion"


def test_large_motion_is_drawn_to_scale(falling: Response) -> None:
    assert falling.overturned
    figure = falling.plot_model()
    assert factor(figure) == 1.0
    # the column is still on its way: half of its height has not been passed
    top = np.asarray(figure.axes[0].patches[0].get_path().vertices)[2:4, 0].mean()
    assert 0.3 * 14.07 < abs(top) <= 0.5 * 14.07


def test_a_column_at_rest_is_drawn() -> None:
    still = simulate(phocas(1e-3), Motion.from_samples(0.1, np.zeros(11)))
    assert factor(still.plot_model()) == 1.0


def test_labels_are_spread() -> None:
    wanted = [9.0, 8.9, 8.8, 2.0, 0.1, 0.05]
    places = spread(wanted, 1.0, 0.0, 9.0)
    assert np.max(np.diff(places)) <= -1.0 + 1e-12
    assert places[0] <= 9.0
    assert places[-1] >= 0.0
    assert spread([5.0, 3.0], 1.0, 0.0, 9.0) == [5.0, 3.0]


def test_no_two_names_of_joints_that_open_collide() -> None:
    block = Block(0.6, 1.6, 1.6, 3000.0, Joint(5.2e9, 1e-3), section="circle")
    figure = capacity_curve(Column("ten", (block,) * 10)).plot()
    FigureCanvasAgg(figure).draw()
    names = [text for text in figure.axes[0].texts if "opens" in text.get_text()]
    boxes = [Text.get_window_extent(text) for text in names]
    assert len(boxes) >= 8
    assert not [1 for a, b in combinations(boxes, 2) if a.overlaps(b)]


def test_a_film_lasts_as_long_as_the_motion(response: Response, tmp_path: Path) -> None:
    response.film(tmp_path / "column.gif", fps=10, speed=0.5)
    with Image.open(tmp_path / "column.gif") as film:
        assert getattr(film, "n_frames", 1) == 31  # 3 s of film for 1.5 s of motion, both ends
        assert film.info["duration"] == 100
        first = np.asarray(film.convert("RGB"), dtype=float)
        film.seek(12)
        later = np.asarray(film.convert("RGB"), dtype=float)
    assert np.mean(np.abs(later - first)) > 0.1
    assert np.all(first[-1, 0] == 255.0)  # the paper stays white
    assert [path.name for path in tmp_path.iterdir()] == ["column.gif"]


@pytest.mark.parametrize("fps", [30, 40, 52, 60])
def test_a_gif_plays_at_the_speed_asked_for(response: Response, tmp_path: Path, fps: int) -> None:
    """Sum the durations that the file stores, in hundredths of a second: 1.5 s of motion at half the speed."""
    response.film(tmp_path / "column.gif", fps=fps, speed=0.5)
    with Image.open(tmp_path / "column.gif") as film:
        shown = 0.0
        for k in range(getattr(film, "n_frames", 1)):
            film.seek(k)
            shown += 1e-3 * film.info["duration"]
    assert shown == pytest.approx(3.0, abs=0.05)  # the last picture is shown, too


@pytest.mark.skipif(not FFMpegWriter.isAvailable(), reason="ffmpeg is not installed")
def test_a_film_as_mp4(response: Response, tmp_path: Path) -> None:
    response.film(tmp_path / "column.mp4", speed=2.0)
    assert (tmp_path / "column.mp4").read_bytes()[4:8] == b"ftyp"


def test_films_without_ffmpeg(monkeypatch: pytest.MonkeyPatch, response: Response, tmp_path: Path) -> None:
    monkeypatch.setattr(FFMpegWriter, "isAvailable", classmethod(lambda cls: False))
    with pytest.raises(InputError, match=r"column\.mp4: needs ffmpeg, which is not installed; \.gif does not"):
        response.film(tmp_path / "column.mp4")
    assert not list(tmp_path.iterdir())


def test_what_makes_no_sense_is_refused(response: Response, tmp_path: Path) -> None:
    for options, said in (
        ({"at": 9.0}, r"^at = 9\.0: must be a time of the response, 0 to 1\.5 s"),
        ({"scale": 0.0}, r"^scale = 0\.0: must be a positive factor"),
        ({"path": tmp_path / "column.xyz"}, "must end in one of"),
    ):
        with pytest.raises(InputError, match=said):
            response.plot_model(**options)
    with pytest.raises(InputError, match=r"must end in \.gif or \.mp4"):
        response.film(tmp_path / "column.png")
    with pytest.raises(InputError, match=r"^speed = 0\.0001: makes 300001 pictures, must be larger"):
        response.film(tmp_path / "column.gif", speed=1e-4)
    with pytest.raises(InputError, match=r"^fps = 0: must be"):
        response.film(tmp_path / "column.gif", fps=0)
    assert not list(tmp_path.iterdir())


def test_a_film_says_how_far_it_is_and_ends_after_a_fall(falling: Response, tmp_path: Path) -> None:
    seen: list[tuple[int, int]] = []
    falling.film(tmp_path / "fall.gif", fps=10, callback=lambda done, total: seen.append((done, total)))
    end = min(falling.time[-1], falling.overturn_time + 1.0)
    assert seen == [(k, len(seen)) for k in range(1, len(seen) + 1)]
    assert len(seen) == int(end / 0.1 + 1e-9) + 1


def test_more_blocks_than_colours(tmp_path: Path) -> None:
    column: Column = phocas(1e-3)
    many = simulate(Column("many", column.blocks * 3), Motion.harmonic(0.1, 2.0, 0.2))
    many.film(tmp_path / "many.gif")
    assert (tmp_path / "many.gif").stat().st_size > 10_000
