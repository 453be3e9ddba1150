"""Checks the result of a packing library: the placement at which a box of a load first loses its support."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import isfinite
from types import MappingProxyType
from typing import Final, Literal, TypeAlias

from stability.geometry.box import Box
from stability.geometry.vectors import add, scale, subtract
from stability.model import GROUND, Brick, Plane, Pose, Vec3
from stability.problem import Stability, Tolerances
from stability.statics.assembly import Assembly
from stackdsl.language.bricks import Form, box_form, compound_form
from stackdsl.language.pallets import CLOSED, DECK_BRICK, EUR_MASS, boards_of, pallet_boxes, parse_deck_size
from stackdsl.language.quantities import InputError
from stackdsl.wording import mm

__all__ = ["LostPlacement", "PackedBox", "PackingResult", "check"]

Unit: TypeAlias = Literal["mm", "cm", "m", "in"]
METRES: Final[Mapping[Unit, Fraction]] = MappingProxyType(
    {"mm": Fraction(1, 1000), "cm": Fraction(1, 100), "m": Fraction(1), "in": Fraction(254, 10000)}
)
DECK_HEIGHT: Final = 0.144  # [m]
DIGITS: Final = 12  # decimals of a metre
TOUCHING: Final = 1e-6  # [m] deeper boxes are inside each other, and those further apart do not touch
APART: Final = 1e-5  # [m] by which boxes are narrower on each side, so that neighbours do not touch


@dataclass(frozen=True, slots=True)
class PackedBox:
    """A box as it lies: its lower corner from the corner of the deck, its sides along x, y and z, and its mass [kg].

    Lengths are in the unit that is given to `check`; z counts from the top of the deck.
    """

    name: str
    corner: tuple[float, float, float]
    size: tuple[float, float, float]
    mass: float


@dataclass(frozen=True, slots=True)
class LostPlacement:
    """The first placement after which the load is not proven to stand."""

    index: int  # of the box, from 0
    name: str
    reason: str  # such as `c7 tips over c3, towards +x`
    moving: tuple[str, ...]  # a smallest set of boxes that move; empty for a box inside another
    stability: Literal["unstable", "undecided", "overlap"]


@dataclass(frozen=True, slots=True)
class PackingResult:
    """The proven part of a load. It is true if the whole load stands, box by box."""

    placed: int  # number of boxes that are proven to stand, in the order of placing
    lost: LostPlacement | None  # None if all stand
    overhang_mm: float  # the largest distance by which a box reaches beyond the deck; 0 if all are inside

    def __bool__(self) -> bool:
        return self.lost is None

    def __str__(self) -> str:
        if self.lost is None:
            return f"all {self.placed} boxes stand when they are placed"
        return f"box {self.lost.index + 1} of the load, {self.lost.name}: {self.lost.reason}"


def check(  # noqa: PLR0913 -- a load, its deck, and how it is judged
    boxes: Iterable[PackedBox],
    deck: str | Sequence[float] | None = "EUR",
    *,
    unit: Unit = "mm",
    friction: float = 0.4,
    surface: str | Sequence[float] = CLOSED,
    neighbours: bool = False,
) -> PackingResult:
    """Return the first placement of a load at which it is not proven to stand; boxes are placed one after another.

    `deck` is the name of a standard pallet, its length and width, or None for a floor without end. `surface` is
    `closed`, `boards` of an EUR pallet, or the width of each board along x. Lengths are in `unit`, masses in kg, and
    `friction` is the coefficient of all contacts. Boxes beside each other do not hold each other unless `neighbours` is
    true: their friction can keep a box over a hole, but a gap of a millimetre takes it away. Each box is therefore
    taken as narrower by 0.01 mm on each side.

    Raises ValueError for sizes, masses or names that are impossible, and for decks that do not exist.
    """
    metres = _scale(unit)
    whole, form = _deck(deck, surface, metres)
    packed = list(boxes)
    _refuse_names([box.name for box in packed])
    floor = 0.0 if form is None else -DECK_HEIGHT
    ground = Plane(GROUND, (0.0, 0.0, floor), (0.0, 0.0, 1.0), friction=friction)
    tolerances = Tolerances() if neighbours else Tolerances(within=TOUCHING)
    assembly = Assembly((ground,), friction=friction, tolerances=tolerances)
    apart = 0.0 if neighbours else APART
    if form is not None:
        x, y, z = form.origin
        centre = (0.5 * whole[0] - x, 0.5 * whole[1] - y, -0.5 * DECK_HEIGHT - z)
        assembly.add(Brick(DECK_BRICK, form.shape, EUR_MASS), Pose(centre))
    for box in packed:
        _refuse_impossible(box)
    lows, highs = [_scaled(box.corner, metres) for box in packed], list[Vec3]()
    for box, low in zip(packed, lows, strict=True):
        highs.append(_rounded(add(low, _scaled(box.size, metres))))
    beyond = 0.0
    if form is not None:
        ends = [max(-low[k], high[k] - whole[k]) for low, high in zip(lows, highs, strict=True) for k in (0, 1)]
        beyond = 1000.0 * max(ends, default=0.0)
    for index, box in enumerate(packed):
        lost = _overlap(index, packed, lows, highs) or _place(assembly, index, box, lows[index], highs[index], apart)
        if lost is not None:
            return PackingResult(index, lost, _overhang(beyond))
    return PackingResult(len(packed), None, _overhang(beyond))


def _overhang(beyond: float) -> float:
    return round(beyond, DIGITS) if beyond > 0.0 else 0.0


def _scale(unit: Unit) -> Fraction:
    if unit not in METRES:
        raise ValueError(f"{unit!r} is not a unit of lengths; write one of {', '.join(METRES)}")
    return METRES[unit]


def _scaled(lengths: Sequence[float], metres: Fraction) -> Vec3:
    """Return three lengths in metres, without the rounding error of products of decimals."""
    x, y, z = (float(Fraction(repr(float(length))) * metres) for length in lengths)
    return _rounded((x, y, z))


def _rounded(point: Vec3) -> Vec3:
    return round(point[0], DIGITS), round(point[1], DIGITS), round(point[2], DIGITS)


def _deck(
    deck: str | Sequence[float] | None, surface: str | Sequence[float], metres: Fraction
) -> tuple[Vec3, Form | None]:
    """Return the sides of a pallet [m] and its form; no form for a floor. Raises ValueError."""
    if deck is None:
        return (0.0, 0.0, 0.0), None
    try:
        if isinstance(deck, str):
            size = parse_deck_size(deck)
        else:
            length, width = deck
            size = Fraction(repr(float(length))) * metres, Fraction(repr(float(width))) * metres
        widths = surface if isinstance(surface, str) else tuple(float(width) * float(metres) for width in surface)
        whole = (float(size[0]), float(size[1]), DECK_HEIGHT)
        boards = boards_of(size, widths)
        return whole, compound_form(pallet_boxes(whole, boards)) if boards else box_form(whole)
    except InputError as error:
        raise ValueError(f"{error.message}; {error.hint}") from error


def _refuse_names(names: Sequence[str]) -> None:
    """Raise ValueError for a name of two boxes, and for that of the deck or the floor."""
    seen = {DECK_BRICK, GROUND}
    for name in names:
        if name in seen:
            taken = "is that of the deck or the floor" if name in (DECK_BRICK, GROUND) else "is that of two boxes"
            raise ValueError(f"the name {name!r} {taken}; give each box a name of its own")
        seen.add(name)


def _refuse_impossible(box: PackedBox) -> None:
    """Raise ValueError for numbers that no box has."""
    if not all(isfinite(number) for number in (*box.corner, *box.size, box.mass)):
        raise ValueError(f"box {box.name!r} has a number that is not finite")
    if min(*box.size, box.mass) <= 0.0:
        raise ValueError(f"box {box.name!r} has a side or a mass that is not greater than zero")


def _overlap(
    index: int, packed: Sequence[PackedBox], lows: Sequence[Vec3], highs: Sequence[Vec3]
) -> LostPlacement | None:
    """Return the placement of a box inside an earlier one or the deck; None if it is inside none."""
    low, high = lows[index], highs[index]
    inside = {DECK_BRICK: -low[2]}
    for other in range(index):
        inside[packed[other].name] = min(
            min(high[axis], highs[other][axis]) - max(low[axis], lows[other][axis]) for axis in range(3)
        )
    name = max(inside, key=inside.__getitem__)
    if inside[name] <= TOUCHING:
        return None
    return LostPlacement(index, packed[index].name, f"it is {mm(inside[name])} inside {name}", (), "overlap")


def _place(  # noqa: PLR0913, PLR0917 -- a box and its place
    assembly: Assembly, index: int, box: PackedBox, low: Vec3, high: Vec3, apart: float
) -> LostPlacement | None:
    """Place a box; return the placement if the load is not proven to stand then."""
    length, width, height = subtract(high, low)
    size = _rounded((length - 2.0 * apart, width - 2.0 * apart, height))
    verdict = assembly.add(Brick(box.name, Box(size), float(box.mass)), Pose(_rounded(scale(0.5, add(low, high)))))
    match verdict.stability:
        case Stability.STABLE:
            return None
        case Stability.UNSTABLE:
            return LostPlacement(index, box.name, verdict.reason, verdict.moving, "unstable")
    return LostPlacement(index, box.name, f"undecided: {verdict.reason}", verdict.moving, "undecided")
