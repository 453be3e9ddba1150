"""A load: boxes and convex solids with exact places, as read from a file."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Final, TypeAlias

from stability.contact_law import Rule
from stability.model import Vec3
from stackdsl.diagnostics import MOST_REPORTED, Diagnostic, Page, Span, reading_order
from stackdsl.language.yaml.source import Plain

# What is taken from a file: boxes and convex solids with exact places, and what the file has that is not taken.


Exact3: TypeAlias = tuple[Fraction, Fraction, Fraction]
LEVEL: Final[Exact3] = (Fraction(0), Fraction(0), Fraction(0))


@dataclass(frozen=True, slots=True)
class ImportedBox:
    """One box of a file, or one convex solid in the box around it, in the frame of that file."""

    name: str | None  # None for a name by place
    size: Exact3  # along its own axes [m]
    centre: Exact3  # [m]
    mass: Fraction  # [kg]
    span: Span  # where in the file it is
    turn: Exact3 = LEVEL  # about x, then y, then z, fixed axes [deg]
    corners: tuple[Exact3, ...] | None = None  # of a solid, along its own axes, from `centre`; None for a box [m]
    heavy_at: Exact3 | None = None  # the centre of mass, likewise; None for that of an even filling
    friction: Fraction | None = None  # Coulomb coefficient of its own

    @property
    def is_upright(self) -> bool:
        """Whether it is a box whose height is vertical."""
        return self.corners is None and self.turn[:2] == LEVEL[:2]

    @property
    def bottom(self) -> Fraction:
        """Height of its lower face, if it is upright [m]."""
        return self.centre[2] - self.size[2] / 2

    @property
    def top(self) -> Fraction:
        """Height of its upper face, if it is upright [m]."""
        return self.centre[2] + self.size[2] / 2


@dataclass(frozen=True, slots=True)
class ImportedSurfaces:
    """What a file says of how its bodies rub, each of which has a friction of its own then."""

    rule: Rule | None  # what two that touch have, as its format has it; None if that leaves it open
    ground: Fraction | None = None  # Coulomb coefficient; None if the file has no ground


@dataclass(frozen=True, slots=True)
class Deck:
    """The deck of a pallet, seen from above; it is at height 0."""

    size: tuple[Fraction, Fraction]  # along x and y [m]
    corner: tuple[Fraction, Fraction] = (Fraction(0), Fraction(0))  # the least x and y [m]


@dataclass(frozen=True, slots=True)
class ImportedLoad:
    """The boxes of a file, in the order in which it lists them."""

    boxes: tuple[ImportedBox, ...]
    precision: Fraction  # the unit of the last digit of its lengths [m]
    untaken: tuple[str, ...] = ()  # what the format has that says nothing of statics, and is there
    surfaces: ImportedSurfaces | None = None  # None if the scenario says how all rub
    deck: Deck | None = None  # None if the file says none


class UnreadableLoadError(Exception):
    """Why a file is not taken."""

    def __init__(self, diagnostics: Sequence[Diagnostic]) -> None:
        super().__init__(diagnostics)
        self.diagnostics = tuple(diagnostics)


@dataclass(slots=True)
class LoadReading:
    """A file while it is read: its mistakes are gathered, and told together."""

    page: Page
    ignored: frozenset[str] = frozenset()  # what its author knows is not taken
    mistakes: list[Diagnostic] = field(default_factory=list)
    untaken: dict[str, None] = field(default_factory=dict)
    used: set[str] = field(default_factory=set)  # of what is ignored
    finest: Fraction | None = None  # unit of the last digit of all lengths so far [m]
    beside: Callable[[str], bytes] | None = None  # what a file holds that it names, as seen from it; or OSError

    def wrong(self, span: Span, message: str, hint: str) -> None:
        """Something is not as the format says."""
        self._told(Diagnostic("SD114", span, message, hint))

    def open(self, span: Span, message: str, hint: str) -> None:
        """Something is left open, and only the author knows."""
        self._told(Diagnostic("SD115", span, message, hint))

    def _told(self, mistake: Diagnostic) -> None:
        self.mistakes.append(mistake)
        if len(self.mistakes) > MOST_REPORTED:
            self.end()

    def end(self) -> None:
        """Raise UnreadableLoadError if anything is wrong."""
        if self.mistakes:
            raise UnreadableLoadError(sorted(self.mistakes, key=reading_order))

    def leave(self, name: str, span: Span, known: bool, meant: str = "") -> None:
        """Something of the file is not taken: `known` says nothing of statics; else its author must have said so.

        `meant` is how it would be taken, if it is what it seems to be.
        """
        if name in self.ignored:
            self.used.add(name)
        elif known:
            self.untaken[name] = None
        else:
            hint = f"if it may be passed over, write ignore: ['{name}']"
            self.open(span, f"'{name}' is nothing that is taken", f"{meant}; {hint}" if meant else hint)

    def file_beside(self, named: str, span: Span) -> bytes:
        """What another file holds that this one names; told and empty if it cannot be read."""
        if self.beside is None:
            self.wrong(span, f"'{named}' cannot be looked for: the file is read by itself", "name a file in a folder")
            return b""
        try:
            return self.beside(named)
        except OSError as error:
            self.wrong(span, f"cannot read '{named}': {error.strerror or error}", "put it beside this file")
            return b""

    def digit(self, unit: Fraction) -> None:
        """A length has a last digit of this unit [m]."""
        self.finest = unit if self.finest is None else min(unit, self.finest)

    def load(self, boxes: Sequence[ImportedBox]) -> ImportedLoad:
        """What was read. Raises UnreadableLoadError if anything was wrong, or if there is nothing."""
        self.end()
        start = self.page.span(0, 0)
        for name in sorted(self.ignored - self.used):
            self.open(start, f"there is no '{name}' that could be ignored", "leave it out of `ignore`")
        if not boxes:
            self.wrong(start, "there is no brick in it", "name a file with boxes, or with convex solids")
        self.end()
        return ImportedLoad(tuple(boxes), self.finest or Fraction(0), tuple(self.untaken))


# A load as a whole somewhere else.


def shifted(load: ImportedLoad, by: Vec3) -> ImportedLoad:
    """The load, moved by so much [m]."""
    if by == (0.0, 0.0, 0.0):
        return load
    x, y, z = (Fraction(repr(part)) for part in by)

    def moved(box: ImportedBox) -> ImportedBox:
        return replace(box, centre=(box.centre[0] + x, box.centre[1] + y, box.centre[2] + z))

    deck = load.deck and replace(load.deck, corner=(load.deck.corner[0] + x, load.deck.corner[1] + y))
    return replace(load, boxes=tuple(map(moved, load.boxes)), deck=deck)


# A load as the items of `bricks`, as an author would write them.


def written_box(box: ImportedBox) -> dict[str, Plain]:
    """One box as an item of `bricks`."""
    named: dict[str, Plain] = {"name": box.name} if box.name is not None else {}
    turn: dict[str, Plain] = {} if box.turn == LEVEL else {"rotate": [f"{digits(part)} deg" for part in box.turn]}
    brick: dict[str, Plain] = _form(box) | {"mass": f"{digits(box.mass)} kg"}
    if box.heavy_at is not None:
        brick["centre_of_mass"] = _lengths(box.heavy_at)
    rubs: dict[str, Plain] = {} if box.friction is None else {"friction": float(box.friction)}
    return {**named, "at": _lengths(box.centre), **turn, "brick": brick, **rubs}


def _form(box: ImportedBox) -> dict[str, Plain]:
    if box.corners is None:
        return {"size": _lengths(box.size)}
    return {"points": [_lengths(corner) for corner in box.corners]}


def _lengths(parts: Exact3) -> list[Plain]:
    return [_length(part) for part in parts]


def _length(metres: Fraction) -> str:
    return f"{digits(1000 * metres)} mm"


def digits(number: Fraction) -> str:
    """A number in as few digits as tell it from other doubles."""
    text = repr(float(number))
    return text.removesuffix(".0")
