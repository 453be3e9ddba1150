"""A load: boxes and convex solids with exact positions, read from a file."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from types import MappingProxyType
from typing import Any, Final, TypeAlias

from stability.contact_law import Rule
from stability.model import Vec3
from stackdsl.diagnostics import MOST_REPORTED, Diagnostic, Page, Span, reading_order
from stackdsl.language.lego import PITCH, PLATE, PLATES
from stackdsl.language.yaml.source import Plain

Exact3: TypeAlias = tuple[Fraction, Fraction, Fraction]
TOTALS: Final = "totals"  # in `ignore`: rows of a table without size and position
BASE_PLATE: Final = "base plate"  # in `ignore`: bricks with studs stand on a ground without studs
LEVEL: Final[Exact3] = (Fraction(0), Fraction(0), Fraction(0))


@dataclass(frozen=True, slots=True)
class ImportedBox:
    """A box of a file, or a convex solid with its bounding box, in the frame of the file."""

    name: str | None  # None: named by its number later
    size: Exact3  # along its body axes [m]
    centre: Exact3  # [m]
    mass: Fraction  # [kg]
    span: Span  # in the file
    turn: Exact3 = LEVEL  # about x, then y, then z, fixed axes [deg]
    corners: tuple[Exact3, ...] | None = None  # of a solid, along its body axes, from `centre`; None for a box [m]
    parts: tuple[tuple[Exact3, ...], ...] | None = None  # corners of the convex parts of another solid, likewise
    centre_of_mass: Exact3 | None = None  # along its body axes, from `centre` [m]; None for uniform density
    friction: Fraction | None = None  # Coulomb coefficient; None to use that of the scenario
    kind: str | None = None  # of the catalogue; None for one with this size and mass
    has_studs: bool = False  # whether LEGO studs hold it
    curved: str | None = None  # `cylinder`, `sphere` or `capsule` along its body z axis, with this `size`; None if not

    @property
    def is_upright(self) -> bool:
        """Whether this is a box with a vertical height axis."""
        return self.corners is None and self.curved is None and self.turn[:2] == LEVEL[:2]

    @property
    def bottom(self) -> Fraction:
        """Height of the lower face [m]; upright boxes only."""
        return self.centre[2] - self.size[2] / 2

    @property
    def top(self) -> Fraction:
        """Height of the upper face [m]; upright boxes only."""
        return self.centre[2] + self.size[2] / 2


@dataclass(frozen=True, slots=True)
class ImportedSurfaces:
    """Friction settings of a file in which each body has its own friction."""

    rule: Rule | None  # combines the frictions of two bodies in contact; None if the format defines none
    ground: Fraction | None = None  # Coulomb coefficient of the ground; None if the file has no ground


@dataclass(frozen=True, slots=True)
class Deck:
    """The deck of a pallet in plan; its height is 0."""

    size: tuple[Fraction, Fraction]  # along x and y [m]
    corner: tuple[Fraction, Fraction] = (Fraction(0), Fraction(0))  # smallest x and y [m]


@dataclass(frozen=True, slots=True)
class ImportedLoad:
    """The boxes of a file, in file order."""

    boxes: tuple[ImportedBox, ...]
    precision: Fraction  # the unit of the last digit of its lengths [m]
    skipped: tuple[str, ...] = ()  # names of data in the file that do not affect statics and were not read
    surfaces: ImportedSurfaces | None = None  # None if the scenario sets all frictions
    deck: Deck | None = None  # None if the file gives none
    likely_point: str = ""  # `corner` or `centre`, if the lowest boxes of a table show it
    on_base_plate: bool = False  # whether LEGO studs on the ground hold the lowest boxes
    prefix: str = ""  # put before names that begin with a digit; empty if there are none


class UnreadableLoadError(Exception):
    """A file cannot be read as a load; carries the diagnostics, and values of `import` that may answer them."""

    def __init__(self, diagnostics: Sequence[Diagnostic], proposed: Mapping[str, Any] = MappingProxyType({})) -> None:
        super().__init__(diagnostics)
        self.diagnostics, self.proposed = tuple(diagnostics), proposed


@dataclass(slots=True)
class LoadReading:
    """State of reading one file; collects its mistakes, to report them together."""

    page: Page
    ignored: frozenset[str] = frozenset()  # names that the author listed under `ignore`
    mistakes: list[Diagnostic] = field(default_factory=list)
    skipped: dict[str, None] = field(default_factory=dict)
    used: set[str] = field(default_factory=set)  # names in `ignored` that occurred in the file
    proposed: dict[str, Any] = field(default_factory=dict)  # values of `import` for properties that are left open
    renamed: dict[str, str] = field(default_factory=dict)  # headers in the file of columns that `map` renames
    finest: Fraction | None = None  # unit of the last digit of all lengths so far [m]
    data: bytes = b""  # the whole file, of formats that may be binary
    read_file: Callable[[str], bytes] | None = None  # bytes of a file, by a path relative to this one; raises OSError

    def wrong(self, span: Span, message: str, hint: str) -> None:
        """Report a violation of the format."""
        self._report(Diagnostic("SD114", span, message, hint))

    def undetermined(self, span: Span, message: str, hint: str) -> None:
        """Report a property that the file leaves open and the author must set."""
        self._report(Diagnostic("SD115", span, message, hint))

    def _report(self, mistake: Diagnostic) -> None:
        self.mistakes.append(mistake)
        if len(self.mistakes) > MOST_REPORTED:
            self.end()

    def end(self) -> None:
        """Raise UnreadableLoadError if any mistake was reported."""
        if self.mistakes:
            raise UnreadableLoadError(sorted(self.mistakes, key=reading_order), self.proposed)

    def skip(self, name: str, span: Span, harmless: bool, advice: str = "") -> None:
        """Skip data of the file.

        Data that may affect statics (not `harmless`) are reported unless the author ignores them by name. `advice`
        says how to write data that look like a misspelt property.
        """
        if name in self.ignored:
            self.used.add(name)
        elif harmless:
            self.skipped[name] = None
        else:
            hint = f"to ignore it, write `ignore: ['{name}']`"
            self.undetermined(span, f"'{name}' is not supported", f"{advice}; {hint}" if advice else hint)

    def bytes_beside(self, name: str, span: Span) -> bytes:
        """Read another file that this file names; report and return b"" if that fails."""
        if self.read_file is None:
            message = f"'{name}' cannot be read, since the folder of this file is unknown"
            self.wrong(span, message, "pass the path of this file instead of its content")
            return b""
        try:
            return self.read_file(name)
        except OSError as error:
            self.wrong(span, f"cannot read '{name}': {error.strerror or error}", "put it into the folder of this file")
            return b""

    def note_precision(self, unit: Fraction) -> None:
        """Record the unit of the last digit of a length [m]."""
        self.finest = unit if self.finest is None else min(unit, self.finest)

    def load(self, boxes: Sequence[ImportedBox]) -> ImportedLoad:
        """Return the load of these boxes. Raises UnreadableLoadError for any mistake, or without boxes."""
        self.end()
        start = self.page.span(0, 0)
        for name in sorted(self.ignored - self.used - {BASE_PLATE, TOTALS}):
            self.undetermined(
                start, f"`ignore` lists '{name}', but the file does not contain it", "remove it from `ignore`"
            )
        if not boxes:
            self.wrong(start, "the file contains no bricks", "import a file with boxes or convex solids")
        self.end()
        return ImportedLoad(tuple(boxes), self.finest or Fraction(0), tuple(self.skipped))


def shifted(load: ImportedLoad, by: Vec3) -> ImportedLoad:
    """Return the load, translated [m]."""
    if by == (0.0, 0.0, 0.0):
        return load
    x, y, z = (Fraction(repr(part)) for part in by)

    def translated(box: ImportedBox) -> ImportedBox:
        return replace(box, centre=(box.centre[0] + x, box.centre[1] + y, box.centre[2] + z))

    deck = load.deck and replace(load.deck, corner=(load.deck.corner[0] + x, load.deck.corner[1] + y))
    return replace(load, boxes=tuple(map(translated, load.boxes)), deck=deck)


def written_box(box: ImportedBox) -> dict[str, Plain]:
    """Return a box as an item of `bricks` in YAML."""
    if box.has_studs:
        return _written_on_studs(box)
    name: dict[str, Plain] = {"name": box.name} if box.name is not None else {}
    turn: dict[str, Plain] = {} if box.turn == LEVEL else {"rotate": [f"{digits(part)} deg" for part in box.turn]}
    brick: dict[str, Plain] = _form(box) | {"mass": f"{digits(box.mass)} kg"}
    if box.centre_of_mass is not None:
        brick["centre_of_mass"] = _lengths(box.centre_of_mass)
    friction: dict[str, Plain] = {} if box.friction is None else {"friction": float(box.friction)}
    return {**name, "at": _lengths(box.centre), **turn, "brick": brick, **friction}


def _written_on_studs(box: ImportedBox) -> dict[str, Plain]:
    """Return a brick with studs, by its place in studs if it is on their grid."""
    brick: Plain = box.kind or {"size": _lengths(box.size), "mass": f"{digits(box.mass)} kg", "studs": "lego"}
    length, width, height = box.size
    x, y, z = box.centre
    turned = box.turn != LEVEL
    along, across = (width, length) if turned else (length, width)
    cell = (x - along / 2) / PITCH, (y - across / 2) / PITCH, (z - height / 2) / PLATE
    place: dict[str, Plain]
    if all(part.denominator == 1 for part in cell) and cell[2] >= 0:
        plates = int(cell[2])
        count, unit = (plates // PLATES, "brick") if plates % PLATES == 0 else (plates, "plate")
        tall: Plain = f"{count} {unit}{'s' * (count > 1)}" if plates else 0
        place = {"stud": [int(cell[0]), int(cell[1]), tall], **({"turned": True} if turned else {})}
    else:
        rotate: list[Plain] = [f"{digits(part)} deg" for part in box.turn]
        place = {"at": _lengths(box.centre), **({"rotate": rotate} if turned else {})}
    return {"name": box.name, **place, "brick": brick}


def _form(box: ImportedBox) -> dict[str, Plain]:
    if box.curved is not None:
        across, height = _length(box.size[0]), _length(box.size[2])
        lengths: dict[str, Plain] = {"diameter": across}
        return {box.curved: lengths if box.curved == "sphere" else {**lengths, "height": height}}
    if box.corners is None:
        return {"size": _lengths(box.size)}
    if box.parts is not None:
        return {"parts": [{"points": [_lengths(corner) for corner in part]} for part in box.parts]}
    return {"points": [_lengths(corner) for corner in box.corners]}


def _lengths(parts: Exact3) -> list[Plain]:
    return [_length(part) for part in parts]


def _length(metres: Fraction) -> str:
    return f"{digits(1000 * metres)} mm"


def digits(number: Fraction) -> str:
    """Format a number with the fewest digits that distinguish it from other doubles."""
    text = repr(float(number))
    return text.removesuffix(".0")
