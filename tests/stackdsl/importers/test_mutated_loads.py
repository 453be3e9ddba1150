"""Files that something happened to: told in their place, or read as they are; never a box less, or another one."""

import random
import re
from collections.abc import Iterator

import pytest

from stability.geometry.convex_parts import WHOLE
from stackdsl.diagnostics import Diagnostic
from stackdsl.importers.formats import read_load
from stackdsl.importers.load import ImportedLoad, UnreadableLoadError
from stackdsl.language.imports import Format, Import
from tests.stackdsl.importers.loads import (
    BINARIES,
    SAID,
    TEXTS,
    Box,
    beside,
    read_binary_otherwise,
    read_otherwise,
    skip_without_parser,
)

IN_SUITE = 60
ROUNDED = {
    "compas": 1e-12,
    "obj": 1e-12,
    "stl": 1e-12,
    "ply": 1e-12,
    "urdf": 2e-12,
    "mjcf": 1e-7,
    "ldraw": 1e-9,
}  # [m]: MuJoCo keeps meshes in single precision
MANY = 500
WORDS = (*'"{}]:,;-0é\x00\n', "null", "-1", "NaN", "1e999", "", "true", "7mm")


def mutated(text: str, seed: str) -> str:
    """The text after one thing happened to it: cut, or a part of it deleted, doubled, exchanged, or overwritten."""
    chance = random.Random(seed)
    at = chance.randrange(len(text))
    parts = [found.span() for found in re.finditer(r'"[^"]*"|[\w.]+', text)]
    start, end = chance.choice(parts)
    (one, two), (three, four) = sorted(chance.sample(parts, 2))
    ways: list[str] = [
        text[:at],
        text[:at] + text[at + 1 :],
        text[:at] + chance.choice(WORDS) + text[at:],
        text[:start] + text[end:],
        text[:start] + chance.choice(WORDS) + text[end:],
        text[:start] + text[start:end] * 2 + text[end:],
        text[:one] + text[three:four] + text[two:three] + text[one:two] + text[four:],
    ]
    return ways[chance.randrange(len(ways))]


def damaged(data: bytes, seed: str) -> bytes:
    """A binary file after one thing happened to it: cut, or a part of it lost, doubled, exchanged, or overwritten."""
    chance = random.Random(seed)
    one, two, three, four = sorted(chance.sample(range(len(data)), 4))
    ways = [
        data[:one],
        data[:one] + data[one + 1 :],
        data[:one] + chance.randbytes(1) + data[one:],
        data[:one] + bytes([data[one] ^ 1 << chance.randrange(8)]) + data[one + 1 :],
        data[:one] + chance.randbytes(4) + data[one + 4 :],
        data[:one] + data[three:four] + data[two:three] + data[one:two] + data[four:],
        data[:one] + bytes(two - one) + data[two:],
    ]
    return ways[chance.randrange(len(ways))]


def binary_is_told(name: str, seed: int) -> bool:
    """Return whether a damaged binary file was read; check that it was read as by the other reader, or well refused."""
    format_: Format = "stl" if name.startswith("stl") else "ply"
    data = damaged(BINARIES[name], f"{name}-{seed}")
    asked = Import.model_validate({"file": "a", "format": format_, **SAID[format_]})
    try:
        load = read_load(data, "a", asked)
    except UnreadableLoadError as error:
        mistakes = error.diagnostics
    else:
        mistakes = ()
    if mistakes:
        assert all(each.message and each.hint and each.span.file == "a" for each in mistakes)
        return False
    assert_alike(list(boxes(load)), read_binary_otherwise(format_, data), 1e-6, 1e-6, 3e-6)
    return True


def read(format_: Format, text: str) -> ImportedLoad:
    skip_without_parser(format_)
    asked = Import.model_validate({"file": "a", "format": format_, **SAID[format_]})
    return read_load(text.encode("utf-8"), "a", asked, beside)


def boxes(load: ImportedLoad) -> Iterator[Box]:
    for box in load.boxes:
        yield tuple(map(float, box.size)), tuple(map(float, box.centre)), float(box.mass)


def assert_same(load: ImportedLoad, format_: Format, text: str) -> None:
    """Boxes to the last bit; of hulls, sizes and weights are sums of doubles."""
    ours, theirs = list(boxes(load)), read_otherwise(format_, text)
    if format_ in {"table", "pallet-sim", "bed-bpp", "stablelego", "apex-mr", "brickgpt"}:
        assert ours == theirs
        return
    # A damaged solid may be dented: its parts have its volume but for `WHOLE`.
    of_mass = WHOLE if format_ in {"compas", "obj", "stl", "ply"} else 3e-9
    assert_alike(ours, theirs, 1e-9, ROUNDED[format_], of_mass)


def assert_alike(ours: list[Box], theirs: list[Box], rel: float, absolute: float, of_mass: float) -> None:
    """Check that boxes have the same places, sizes [m] and masses, these within a share of their own."""
    assert [[*size, *centre] for size, centre, _ in ours] == [
        pytest.approx([*size, *centre], rel=rel, abs=absolute) for size, centre, _ in theirs
    ]
    assert [mass for _, _, mass in ours] == pytest.approx([mass for _, _, mass in theirs], rel=of_mass)


def nothing_is_lost(format_: Format, seed: int) -> bool:
    """Whether a file was read, as it was by others, rather than refused in its place."""
    text = mutated(TEXTS[format_], f"{format_}-{seed}")
    lines = text.split("\n")
    found = told(format_, text)
    if isinstance(found, ImportedLoad):
        assert_same(found, format_, text)
        return True
    assert found
    for mistake in found:
        assert mistake.span.file == "a"
        assert 1 <= mistake.span.line <= len(lines)
        assert 1 <= mistake.span.column <= len(lines[mistake.span.line - 1]) + 1
        assert mistake.message
        assert mistake.hint
    return False


def told(format_: Format, text: str) -> ImportedLoad | tuple[Diagnostic, ...]:
    """The load, or what is wrong with it."""
    try:
        return read(format_, text)
    except UnreadableLoadError as error:
        return error.diagnostics


@pytest.mark.parametrize("format_", TEXTS)
def test_a_file_that_is_right_is_read_as_others_read_it(format_: Format) -> None:
    assert_same(read(format_, TEXTS[format_]), format_, TEXTS[format_])


@pytest.mark.parametrize("format_", TEXTS)
def test_a_mutated_file_is_told_in_its_place_or_read_whole(format_: Format) -> None:
    accepted = [nothing_is_lost(format_, seed) for seed in range(IN_SUITE)]
    assert 0 < sum(accepted) < IN_SUITE


@pytest.mark.slow
@pytest.mark.parametrize("format_", TEXTS)
def test_many_mutated_loads_are_read_or_refused_with_a_diagnostic(format_: Format) -> None:
    accepted = [nothing_is_lost(format_, seed) for seed in range(MANY)]
    assert 0 < sum(accepted) < MANY


@pytest.mark.parametrize("name", BINARIES)
def test_a_damaged_binary_file_is_told_or_read_whole(name: str) -> None:
    accepted = [binary_is_told(name, seed) for seed in range(IN_SUITE)]
    assert 0 < sum(accepted) < IN_SUITE


@pytest.mark.slow
@pytest.mark.parametrize("name", BINARIES)
def test_many_damaged_binary_files_are_read_or_refused_with_a_diagnostic(name: str) -> None:
    accepted = [binary_is_told(name, seed) for seed in range(MANY)]
    assert 0 < sum(accepted) < MANY


@pytest.mark.parametrize("half", [r"\ud800", r"\uDFFF", r"\udc00\ud800"])
@pytest.mark.parametrize("format_", ["table", "pallet-sim", "compas"])
def test_half_of_a_character_is_told_where_it_stands(format_: Format, half: str) -> None:
    text = '[{"a": 1,\n  "odd%s": 2}]' if format_ == "table" else '{"a": [1,\n  "odd%s"]}'
    found = told(format_, text % half)
    assert not isinstance(found, ImportedLoad)
    (mistake,) = found
    assert (mistake.code, mistake.span.line) == ("SD114", 2)
    assert f"{half[:6].lower()} is half of a surrogate pair" in mistake.message
    whole = told(format_, text % r"\ud83e\uddf1")
    assert isinstance(whole, ImportedLoad) or not any("half" in each.message for each in whole)
