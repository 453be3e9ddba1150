"""Scenarios as a slip of the hand, a bad merge or ill will leaves them: changed at random, the same by each seed."""

from collections.abc import Callable, Sequence
from pathlib import Path
from random import Random
from typing import Any, Final

import yaml

from tests.paths import ROOT

# What the scenarios of the project do not use in every combination.
FEATURES: Final = (
    """\
scenario: features
let: {n: 3, wide: 117.6 mm, kind: beam}
matrix: {step: 5 mm .. 15 mm by 5 mm, tilt: [0 deg, 2 deg]}
exclude: [{step: 5 mm, tilt: 2 deg}]
brick_types: {beam: {size: [200 mm, 20 mm, 10 mm], density: 600 kg/m3}}
world: {tilt: {angle: "${tilt}"}, walls: [{bearing: 90 deg, distance: 2 m}]}
build:
  - {name: foot, bricks: [{name: a, on: ground}, {name: b, on: a, brick: beam}, {beside: foot.a, towards: 90 deg}]}
  - {repeat: {i: 1 .. 4}, bricks: [{name: "c${i}", at: ["${i * wide}", 300 mm, 3.9 mm]}]}
  - {column: {levels: "${n}", step: "${step}", origin: [1 m, 0 m, 0 m]}, every: 0.5 s}
impacts:
  - {repeat: {i: 1 .. 3}, remove: {brick: "c${i}"}, every: 1 s}
  - {after: built + 2 s, throw: {at: level 2, from: {bearing: 90 deg, distance: 10 mm}, speed: 2 m/s}}
  - {push: {brick: foot.a, impulse: [1 mN*s, 0 N*s, 0 N*s]}}
  - {drop: {onto: foot.b, height: 20 mm, name: ball}}
systems: [exact, tuned]
skip: {reason: not played here, system: tuned}
xfail: {reason: known, system: exact}
expect: [{stands: {bricks: [foot.a]}}, {falls: {bricks: [c4]}, system: tuned}, {drift: "<= 3 mm"}]
""",
    """\
scenario: by-cases
tags: [slow, study]
cases: [{name: slow, speed: 1 m/s, shift: 10 mm}, {name: fast, speed: 2 m/s, shift: 40 mm}]
build: [{include: _part.yaml}, {column: {levels: 5, step: "${shift}"}}]
impacts: [{throw: {at: level 1, from: {bearing: 0 deg, distance: 20 mm}, speed: "${speed}"}}]
expect: [{include: _part.yaml}, collapses: {at: level 3}]
---
scenario: extended
extends: {scenario: by-cases}
world: {shake: {along: 0 deg, frequency: 2 Hz, amplitude: 3 mm, duration: 2 s}}
---
scenario: from-another-file
extends: {file: _part.yaml, scenario: part}
let: {high: 4}
""",
)
PART: Final = """\
scenario: part
let: {high: 3}
build: [{name: of-part, four_stack: {levels: 3, origin: [2 m, 0 m, 0 m]}}]
expect: [stands: all]
"""
ODD: Final[Sequence[Any]] = (
    *(0, -1, 1, 7, 10_001, 2**53, 1e308, 1e-308, -0.0, True, None, "", " ", "~", "x", "x" * 3000, "é", "\u202e"),
    *("0 mm", "-5 mm", "1e9 m", "1e-12 m", "5 parsec", "1 m / s", "45 deg", "nan", ".inf", "1e400 kg", "5 mm ± 1 mm"),
    *("${n}", "${", "${1/0}", "${9**64}", "${sqrt(-1)}", "${undefined + 1 m}", "${" + "(" * 70 + "}", "1 .. 20000"),
    *("1 .. 1000000000", "18 .. 1", "5 mm .. 15 mm", "level 99", "brick q", "built + 1 h", "L1.1", "ground", "all"),
    *([], {}, [[]], {"": ""}, {"repeat": {"i": "1 .. 5000"}}, [1] * 500, {"include": "_part.yaml"}, {"extends": "."}),
)
CHARACTERS: Final = "\0\t\r\n :-[]{},'\"|>&*!%@`#?~\\$€\U0001f9f1\ufeff0a"


def sources() -> list[str]:
    """What is changed: every scenario of the project, and the features beside."""
    return [*(path.read_text(encoding="utf-8") for path in sorted((ROOT / "scenarios").rglob("*.yaml"))), *FEATURES]


def mutated(random: Random, texts: Sequence[str]) -> str:
    """One of the texts, changed in one to four places, or woven into another one."""
    text = random.choice(texts)
    if random.random() < 0.4:
        changed = _by_value(random, text)
        text = text if changed is None else changed
    for _ in range(random.randint(0 if random.random() < 0.2 else 1, 3)):
        change: Callable[[Random, str, Sequence[str]], str] = random.choice((_lines, _characters, _words, _woven))
        text = change(random, text, texts)
    return text


def _by_value(random: Random, text: str) -> str | None:
    """Some values replaced, doubled or left out, whatever they are."""
    try:
        documents = list(yaml.safe_load_all(text))
    except yaml.YAMLError:
        return None
    for _ in range(random.randint(1, 3)):
        holders = [holder for document in documents for holder in _holders(document)]
        if not holders:
            return None
        holder = random.choice(holders)
        key = random.choice(list(holder) if isinstance(holder, dict) else range(len(holder)))
        match random.randint(0, 4):
            case 0:
                del holder[key]
            case 1 if isinstance(holder, list):
                holder += [holder[key]] * random.choice([1, 2, 300])
            case 1 | 2:
                holder[key] = random.choice(ODD)
            case 3:
                other = random.choice(holders)
                holder[key] = random.choice(list(other.values() if isinstance(other, dict) else other) or [None])
            case _ if isinstance(holder, dict):
                holder[random.choice(["name", "at", "on", "repeat", "every", "levels", f"{key}s"])] = holder[key]
    return _dumped(documents)


def _dumped(documents: list[Any]) -> str | None:
    try:
        return yaml.safe_dump_all(documents, sort_keys=False, allow_unicode=True)
    except (yaml.YAMLError, RecursionError, ValueError):  # a value put into itself
        return None


def _holders(value: Any, depth: int = 0) -> list[Any]:  # noqa: ANN401 -- YAML
    """All mappings and lists in a value that hold anything."""
    if depth > 20 or not isinstance(value, dict | list) or not value:
        return []
    members = value.values() if isinstance(value, dict) else value
    return [value, *(holder for member in members for holder in _holders(member, depth + 1))]


def _lines(random: Random, text: str, _texts: Sequence[str]) -> str:
    lines = text.splitlines(keepends=True) or [""]
    here, there = random.randrange(len(lines)), random.randrange(len(lines))
    match random.randint(0, 3):
        case 0:
            del lines[here : here + random.randint(1, 3)]
        case 1:
            lines[here:here] = lines[there : there + random.randint(1, 5)] * random.choice([1, 1, 2, 40])
        case 2:
            lines[here], lines[there] = lines[there], lines[here]
        case _:
            lines[here] = " " * random.randint(1, 3) + lines[here] if random.random() < 0.5 else lines[here].lstrip()
    return "".join(lines)


def _characters(random: Random, text: str, _texts: Sequence[str]) -> str:
    at = random.randrange(len(text) + 1)
    return text[:at] + random.choice(["", random.choice(CHARACTERS), random.choice(CHARACTERS) * 200]) + text[at + 1 :]


def _words(random: Random, text: str, texts: Sequence[str]) -> str:
    words, others = text.split(" "), random.choice(texts).split(" ")
    words[random.randrange(len(words))] = random.choice([random.choice(others), str(random.choice(ODD))])
    return " ".join(words)


def _woven(random: Random, text: str, texts: Sequence[str]) -> str:
    other = random.choice(texts)
    return text[: random.randrange(len(text) + 1)] + other[random.randrange(len(other)) :]


def write_mutated(random: Random, texts: Sequence[str], folder: Path) -> Path:
    """A file with a changed scenario, beside the one that some include, which is changed at times, too."""
    part = mutated(random, [PART]) if random.random() < 0.3 else PART
    (folder / "_part.yaml").write_text(part, encoding="utf-8", errors="replace")
    file = folder / "scenario.yaml"
    file.write_text(mutated(random, texts), encoding="utf-8", errors="replace", newline="")
    return file
