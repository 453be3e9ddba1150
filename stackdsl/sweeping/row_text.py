"""Rows as text: a line of JSON each, below a line that says of which sweep they are."""

import json
from collections import Counter
from dataclasses import dataclass, field
from typing import Final

from stackdsl.sweeping.pieces import Kind
from stackdsl.sweeping.sweep_plan import Entry, Plan


class RowsError(Exception):
    """A file that cannot be gone on with: of another sweep, in use, damaged, or one that cannot be written."""


@dataclass
class Counts:
    """How many rows of each kind there are, by the number of the case."""

    of: dict[int, Counter[Kind]] = field(default_factory=dict)

    @property
    def rows(self) -> int:
        """All of them."""
        return sum(counter.total() for counter in self.of.values())

    def add(self, index: int, kind: Kind, count: int = 1) -> None:
        """So many more of a kind."""
        self.of.setdefault(index, Counter())[kind] += count

    def merge(self, more: "Counts") -> None:
        """Add all of those."""
        for index, counter in more.of.items():
            self.of.setdefault(index, Counter()).update(counter)


def head_of(entry: Entry) -> bytes:
    """What a row of a case begins with, up to the number of the sample."""
    return f'{{"case": {json.dumps(entry.name)}, "seed": {json.dumps(entry.seed)}, "sample": '.encode()


def tail_of(kind: Kind) -> bytes:
    """What a row ends with."""
    return b", " + json.dumps(kind._asdict()).encode()[1:] + b"\n"


def number_of(entry: Entry, sample: int) -> bytes:
    """The number of a sample; a case that is played once has none."""
    return b"%d" % sample if entry.case.is_sampled else b"null"


def kind_of(tail: bytes) -> Kind | None:
    """What such an end says; None where it is none."""
    try:
        said = json.loads(b"{" + tail[2:])
        kind = Kind(said["verdict"], said["level"], said["how"])
    except (KeyError, TypeError, ValueError):
        return None
    return kind if tail_of(kind) == tail else None


def header_line(plan: Plan, after: int = 0) -> bytes:
    """The first line of a file, of which so many rows are kept elsewhere."""
    return json.dumps({**plan.header, "after": after}).encode() + b"\n"


def refuse_other(line: bytes, plan: Plan, path: object) -> int:
    """How many rows come before those of a file, by its first line. Raises RowsError where it is of another sweep."""
    try:
        said = json.loads(line)
        differing = [key for key in plan.header if said.get(key) != plan.header[key]]
        after = said["after"]
        cases = {told["case"]: told for told in said["cases"]}
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise RowsError(f"{path} is no file of a sweep: its first line says nothing of one; {_ELSE}") from error
    if differing:
        raise RowsError(f"{path} is of another sweep: {_why(differing, said, cases, plan)}; {_ELSE}")
    return int(after)


_ELSE: Final = "write to another file, or remove this one"


def _why(differing: list[str], said: dict[str, object], cases: dict[str, dict[str, object]], plan: Plan) -> str:
    if "stackdsl" in differing or "rows" in differing:
        return f"stackdsl {said.get('stackdsl')} wrote it, and this is {plan.header['stackdsl']}"
    for entry in plan.entries:
        was = cases.get(entry.name)
        if was is None:
            return f"it has no case '{entry.name}', but {', '.join(cases)}"
        if was.get("seed") != entry.seed:
            return f"'{entry.name}' had seed {was.get('seed')}, and has {entry.seed} now"
        if was.get("scenario") != entry.told["scenario"]:
            return f"'{entry.name}' has been changed since"
    if len(cases) != len(plan.entries):
        gone = [name for name in cases if name not in {entry.name for entry in plan.entries}]
        return f"it also has {', '.join(gone)}"
    if "cases" in differing:
        return "its cases come in another order, or with other values of their parameters"
    return "another program wrote it: the code of stackdsl, Python, numpy, scipy, clarabel or the engine has changed"
