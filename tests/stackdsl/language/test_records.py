"""Records of accelerations from files: what is read, and how cut or unclear files are refused."""

import random
import re
from pathlib import Path

import pytest

from stability.dynamics.ground_motion import TabulatedCourse
from stackdsl.language.quantities import InputError
from stackdsl.language.records import ACCELERATIONS, read_record
from stackdsl.timeline import ShakeAction
from tests.records import STANDARD_GRAVITY, at2, csv, scene_with, shaken, wavelet

VALUES = [0.0, 1.5, -2.25, 0.75, 0.0, 0.25, 0.0]
AT2 = at2(VALUES, 0.02)
CSV = csv("time [s],acceleration [m/s2]", [(0.02 * number, value) for number, value in enumerate(VALUES)])
THREE = csv("time [s],along [g],across [g],up [g]", [(0, 0, 0, 0), (1, 0.1, 0.2, 0.3), (2, 0, 0, 0)])


def motion(folder: Path, files: dict[str, str], shake: str) -> ShakeAction:
    actions = shaken(folder, files, shake).actions
    return next(action for action in actions if isinstance(action, ShakeAction))


def test_a_record_of_peer_is_read_in_its_unit_and_at_its_time_step() -> None:
    rows = read_record(AT2, "r.at2").rows("acceleration", ACCELERATIONS, "acceleration")
    assert [time for time, _ in rows] == pytest.approx([0.02 * number for number in range(7)])
    assert [value for _, value in rows] == pytest.approx(VALUES, abs=1e-6)


@pytest.mark.parametrize(
    ("third", "fourth", "factor"),
    [
        (
            "ACCELERATION TIME HISTORY IN UNITS OF G. FILTER POINTS: HP=0.1 Hz",
            "   3   0.0100    NPTS, DT",
            STANDARD_GRAVITY,
        ),
        ("ACCELERATION, UNITS: CM/SEC/SEC", "NPTS= 3, DT= .01 SEC", 0.01),
        ("Acceleration, unit m/s^2", "npts=3,dt=1.0E-02", 1.0),
    ],
)
def test_older_headers_and_other_units_are_read(third: str, fourth: str, factor: float) -> None:
    record = read_record(f"a\nb\n{third}\n{fourth}\n 1.0E+00-2.0D+00\n .5\n", "r.at2")
    rows = record.rows("acceleration", ACCELERATIONS, "acceleration")
    assert rows == pytest.approx([(0.0, factor), (0.01, -2.0 * factor), (0.02, 0.5 * factor)])


def test_a_table_and_a_record_of_the_same_values_shake_alike(tmp_path: Path) -> None:
    courses = [motion(tmp_path, {"r": text}, "file: r").motion.course for text in (AT2, CSV)]
    first, second = (course.points for course in courses if isinstance(course, TabulatedCourse))
    assert [value for pair in first for value in pair] == pytest.approx([v for pair in second for v in pair], abs=1e-6)


def test_semicolons_tabs_comments_and_milliseconds_are_read() -> None:
    for delimiter in (";", "\t"):
        text = f"# made up\n\ntime (ms){delimiter}acceleration (g)\r\n0{delimiter}0.1\r\n# half\r\n500{delimiter}.2\r\n"
        rows = read_record(text, "r.csv").rows("acceleration", ACCELERATIONS, "acceleration")
        assert rows == pytest.approx([(0.0, 0.980665), (0.5, 1.96133)])


def test_decimal_commas_are_read_between_semicolons_where_no_number_has_a_point() -> None:
    text = "time [s];acceleration [g]\n0,00;-0,5\n0,01;1,250\n"
    rows = read_record(text, "r.csv").rows("acceleration", ACCELERATIONS, "acceleration")
    assert rows == pytest.approx([(0.0, -0.5 * STANDARD_GRAVITY), (0.01, 1.25 * STANDARD_GRAVITY)])
    for unclear in (text.replace("-0,5", "-0.5"), "time [s];acceleration [g]\n0;1,250\n1;1,500\n"):
        with pytest.raises(InputError, match="is not a number"):
            read_record(unclear, "r.csv")


def test_components_are_along_the_bearing_a_quarter_turn_further_and_up(tmp_path: Path) -> None:
    found = motion(tmp_path, {"r.csv": THREE}, "file: r.csv, bearing: 90 deg, scale: 2")
    assert found.motion.at(found.time + 1.0) == pytest.approx(
        [2.0 * STANDARD_GRAVITY * part for part in (-0.2, 0.1, 0.3)]
    )


def test_three_files_are_the_same_as_three_columns(tmp_path: Path) -> None:
    one_by_one = {
        f"{n}.csv": csv("time [s],acceleration [g]", [(0, 0), (1, v), (2, 0)])
        for n, v in zip("abc", (0.1, 0.2, 0.3), strict=True)
    }
    files = motion(tmp_path, one_by_one, "file: a.csv, across: b.csv, up: c.csv, bearing: 20 deg")
    table = motion(tmp_path, {"r.csv": THREE}, "file: r.csv, bearing: 20 deg")
    assert files == table


def test_a_record_begins_with_its_first_row_and_a_later_component_waits(tmp_path: Path) -> None:
    files = {"a.csv": csv("time [s],acceleration [g]", [(2, 0.1), (3, 0.1)])}
    files["b.csv"] = csv("time [s],acceleration [g]", [(2.5, 0.2), (3.5, 0.2)])
    found = motion(tmp_path, files, "file: a.csv, across: b.csv, at: 10 s")
    assert (found.time, found.motion.ends) == (12.0, 13.5)
    assert found.motion.at(12.25) == pytest.approx((0.1 * STANDARD_GRAVITY, 0.0, 0.0))
    assert found.motion.at(12.75) == pytest.approx((0.1 * STANDARD_GRAVITY, 0.2 * STANDARD_GRAVITY, 0.0))


def test_a_vertical_component_alone_leaves_the_ground_level(tmp_path: Path) -> None:
    found = motion(tmp_path, {"r.csv": csv("time [s],up [g]", [(0, 0.1), (1, 0.1)])}, "file: r.csv")
    assert found.motion.at(found.time + 0.5) == pytest.approx((0.0, 0.0, 0.1 * STANDARD_GRAVITY))


# --- files that are refused -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "place", "words"),
    [
        ("", "1:1", "empty"),
        ("hello\n", "1:1", "neither AT2"),
        (AT2[: AT2.rindex("\n", 0, -1) + 1], "5:1", "the file is cut: it has 5 of the 7 values"),
        (AT2.rstrip()[:-3] + "\n", "6:27", "'E' is not a number"),
        (AT2 + " 1.0\n", "7:2", "more than the 7 values"),
        (AT2.replace("UNITS OF G", "UNITS OF CM/S"), "3:38", "'CM/S' is not a unit of acceleration"),
        (AT2.replace(" IN UNITS OF G", ""), "4:1", "the unit of acceleration is missing"),
        (AT2.replace("NPTS=      7", "NPTS= 999999"), "4:7", "the file has 999999 values"),
        (AT2.replace("0.0200", "0.0000"), "4:20", "the time step is '0.0000' s"),
        (AT2.replace("0.0200", "nan"), "4:20", "'nan' is not a number"),
        (AT2.replace("1.5295743E-01", "inf"), "5:18", "'inf' is not a number"),
        (CSV.rstrip("\n"), "8:7", "the last line has no line end"),
        (CSV.rstrip("\n")[:-2] + "\n", "8:1", "the row has 1 cells, but the header has 2"),
        (CSV.replace("m/s2", "ft/s2"), "1:10", "'ft/s2' is not a unit of acceleration"),
        (CSV.replace(" [m/s2]", ""), "1:10", "the unit of acceleration is missing"),
        (CSV.replace("time [s]", "time [h]"), "1:1", "'h' is not a unit of time"),
        (CSV.replace("time [s]", "t [s]"), "1:1", "unknown column 't [s]'"),
        (CSV.replace("time [s],", "up [g],"), "1:1", "the column `time` is missing"),
        ("time [s],time [s]\n0,0\n1,1\n", "1:10", "two columns have the name 'time'"),
        ("time [s],acceleration [g],share\n0,0,0\n1,1,1\n", "1:1", "exclude each other"),
        ("time [s],acceleration [g]\n0,0\n", "2:1", "fewer than two rows"),
        ("time [s],acceleration [g]\n0,0\n2,1\n1,0\n", "4:1", "the time is 1 s, after 2 s"),
        ("time [s],acceleration [g]\n1,0\n1,1\n", "3:1", "all rows have the same time"),
        ("time [s],acceleration [g]\n-1,0\n1,1\n", "2:1", "the time is out of range"),
        ("time [s],acceleration [g]\n0,0\n1,x\n", "3:3", "'x' is not a number"),
        ("time [s];acceleration [g]\n0.0;0\n1;1,5\n", "3:3", "'1,5' is not a number"),
        ("time [s],acceleration [g]\n0,0\n1,1e99\n", "3:3", "'1e99' is out of range"),
    ],
)  # fmt: skip
def test_a_cut_or_unclear_record_is_refused_at_its_place(text: str, place: str, words: str) -> None:
    with pytest.raises(InputError) as refusal:
        read_record(text, "r.txt").rows("acceleration", ACCELERATIONS, "acceleration")
    assert refusal.value.message.startswith(f"r.txt:{place}: ")
    assert words in refusal.value.message
    assert refusal.value.hint


@pytest.mark.parametrize("whole", [AT2, CSV, THREE])
def test_a_record_cut_anywhere_within_its_lines_is_refused(whole: str) -> None:
    for length in range(len(whole) - 1):
        if whole is not AT2 and whole[:length].endswith("\n") and whole[:length].count("\n") > 2:
            continue  # a table that ends with a whole row cannot be told from a shorter one
        with pytest.raises(InputError):
            read_record(whole[:length], "r").rows(*("acceleration" if whole is not THREE else "up", ACCELERATIONS, ""))


@pytest.mark.parametrize("whole", [AT2, CSV, THREE])
def test_mutated_files_are_read_or_refused_with_their_place(whole: str) -> None:
    chance, refusals = random.Random(35), []
    for _ in range(300):
        letters = list(whole)
        for _ in range(chance.randint(1, 6)):
            at = chance.randrange(len(letters))
            letters[at : at + chance.choice((0, 1, 1, 9))] = chance.choice(
                ["", "\n", ",", "\0", "9" * 400, "e5", "-", "\u2028", "\udcff", "é", "NPTS", '"']
            )
        try:
            record = read_record("".join(letters), "r")
            for name in record.columns:
                record.rows(name, ACCELERATIONS, "acceleration")
        except InputError as error:
            refusals.append(error.message)
    assert len(refusals) > 100
    assert [message for message in refusals if not re.match(r"r:[0-9]+:[0-9]+: ", message)] == []


@pytest.mark.parametrize(
    ("shake", "code", "words"),
    [
        ("file: none.at2", "SD113", "does not exist"),
        ("file: ../r.at2", "SD113", "is outside the project"),
        ("file: r.at2, frequency: 2 Hz", "SD108", "applies to a sine, but this shake has a file"),
        ("file: r.at2, acceleration: 2 m/s2", "SD108", "not acceleration and file"),
        ("file: r.at2, scale: 0", "SD104", "not greater than zero"),
        ("file: r.at2, scale: 900", "SD104", "the peak acceleration of the record is 2025 m/s2"),
        ("file: three.csv, up: r.at2", "SD108", "have the component `up`"),
        ("file: r.at2, up: three.csv", "SD114", "three.csv has a column 'along'"),
        ("file: share.csv", "SD114", "has a column 'share'"),
        ("file: r.at2, across: cut.at2", "SD114", "the file is cut"),
        ("file: '${x}.at2'", "SD113", "does not exist"),
        ("acceleration: 2 m/s2, frequency: 2 Hz, for: 1 s, up: r.at2", "SD108", "this shake has no `file`"),
        ("acceleration: 2 m/s2, for: 1 s, pulse: square", "SD104", "square"),
        ("acceleration: 2 m/s2, for: 1 s, frequency: 1 Hz, pulse: triangle", "SD108", "no other course or frequency"),
        ("acceleration: 2 m/s2, pulse: triangle", "SD102", "the duration of the pulse, is missing"),
        ("amplitude: 2 mm, for: 1 s, pulse: triangle", "SD108", "has an `acceleration`"),
        ("acceleration: 2 m/s2, for: 1 ms, pulse: half-sine", "SD104", "too short"),
    ],
)  # fmt: skip
def test_impossible_records_have_a_diagnostic(tmp_path: Path, shake: str, code: str, words: str) -> None:
    (tmp_path / "pyproject.toml").write_text("", encoding="utf-8")
    files = {"r.at2": AT2, "three.csv": THREE, "cut.at2": AT2[:-30], "share.csv": "time [s],share\n0,0\n1,1\n"}
    text = f"scenario: scene\nlet: {{x: r}}\nworld:\n  shake: {{{shake}}}\nbuild: [column: {{levels: 1}}]\n"
    _, mistakes = scene_with(tmp_path, files, text)
    found = [mistake for mistake in mistakes if mistake.code != "SD112"]
    assert [mistake.code for mistake in found] == [code], found
    assert words in found[0].message
    assert found[0].span.line == 4


@pytest.mark.parametrize(
    ("pulse", "gained"),
    [("half-sine", 2.0 / 3.141592653589793), ("rectangle", 1.0), ("triangle", 0.5)],
)
def test_a_pulse_gives_the_ground_the_speed_of_its_area(tmp_path: Path, pulse: str, gained: float) -> None:
    found = motion(tmp_path, {}, f"pulse: {pulse}, acceleration: 3 m/s2, for: 0.4 s")
    assert found.motion.mean_W(found.time, 0.4)[0] == pytest.approx(3.0 * gained)
    assert list(found.motion.peaks) == pytest.approx([3.0])
    assert found.motion.ends - found.time == pytest.approx(0.4)


def test_a_record_of_100000_values_is_read_in_a_second(tmp_path: Path) -> None:
    found = motion(tmp_path, {"r.at2": at2(wavelet(1.0, 0.001, 100_000), 0.001)}, "file: r.at2")
    assert found.motion.ends == pytest.approx(99.999)
