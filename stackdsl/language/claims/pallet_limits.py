"""The claims `overhang`, `weight` and `centre_of_mass`: limits of a load on the deck of its pallet."""

from collections.abc import Collection, Sequence
from math import fsum, hypot
from typing import ClassVar, Final

from pydantic import Field

from stability.geometry.placed_shape import corners_W
from stability.geometry.vectors import add, body_axes, dot, scale, subtract
from stability.model import Pose, Vec3
from stackdsl.language import value_types as t
from stackdsl.language.claims.claim_kind import ClaimKind, claim
from stackdsl.language.claims.claim_result import ClaimResult, all_of, placed, within
from stackdsl.language.model_base import AtLeastOneKey, Shorthand
from stackdsl.language.pallets import DECK_BRICK
from stackdsl.language.tolerances import MassTolerance
from stackdsl.trace import BrickState, BrickTrack, Trace
from stackdsl.wording import mm

SIDES: Final = (("-x", "+x"), ("-y", "+y"))
DIGITS: Final = 9  # decimals of lengths [m] and masses [kg]: more are rounding, which must not decide at a limit
NOTHING: Final = "nothing lies on the deck"


def in_deck_frame(deck: BrickTrack, point_W: Vec3) -> Vec3:
    """Return a point [m, W] in the frame of a deck: its length, its width and up, from the middle of its underside."""
    lows, highs = zip(*_extents(deck), strict=True)
    x, y, z = (dot(subtract(point_W, deck.final.position_W), axis) for axis in body_axes(deck.final.orientation))
    return (x - 0.5 * (lows[0] + highs[0]), y - 0.5 * (lows[1] + highs[1]), z - lows[2])


def _extents(deck: BrickTrack) -> Sequence[tuple[float, float]]:
    """Return the lowest and the highest coordinate of a deck along each body axis, from its centre of mass [m]."""
    return [(min(along), max(along)) for along in zip(*deck.brick.shape.corners, strict=True)]


def packed_pose(track: BrickTrack) -> Pose:
    """Return where a brick is at the end, or where it was placed if it fell: limits are those of the packed load."""
    return track.placed if track.state is BrickState.FALLEN else track.final


def overhangs(deck: BrickTrack, tracks: Collection[BrickTrack]) -> list[tuple[float, str, str]]:
    """Return for each brick by how much it reaches beyond a deck [m], at which side, and its name; negative inside."""
    half = [0.5 * (high - low) for low, high in _extents(deck)]
    found = []
    for track in tracks:
        corners = [in_deck_frame(deck, corner) for corner in corners_W(track.brick.shape, packed_pose(track))]
        beyond = [
            (max(sign * corner[axis] for corner in corners) - half[axis], SIDES[axis][sign > 0])
            for axis in (0, 1)
            for sign in (-1, 1)
        ]
        found.append((*max(beyond), track.brick.id))
    return found


def centre_of_mass_W(tracks: Collection[BrickTrack]) -> Vec3:
    """Return the common centre of mass of bricks [m, W]."""
    mass = fsum(track.brick.mass for track in tracks)
    centre: Vec3 = (0.0, 0.0, 0.0)
    for track in tracks:
        centre = add(centre, scale(track.brick.mass / mass, packed_pose(track).position_W))
    return centre


def centre_on_deck(deck: BrickTrack, load: Collection[BrickTrack]) -> Vec3:
    """Return the centre of mass of a load in the frame of its deck [m]."""
    x, y, z = in_deck_frame(deck, centre_of_mass_W(load))
    return round(x, DIGITS) + 0.0, round(y, DIGITS) + 0.0, round(z, DIGITS)


def deck_and_load(name: str, trace: Trace) -> tuple[BrickTrack, Collection[BrickTrack]] | None:
    """Return the deck and all other bricks of the structure; None while one of them is not placed."""
    tracks = placed(trace)
    deck = next((track for track in tracks if track.brick.id == name), None)
    load = [track for track in tracks if track is not deck]
    return (deck, load) if deck is not None and load else None


@claim("overhang", "how far a load reaches beyond the deck of its pallet")
class Overhang(Shorthand, ClaimKind):
    """The largest horizontal distance by which a brick reaches beyond the deck; 0 if all are inside."""

    within: t.LengthTolerance = Field(alias="is", description="accepted overhangs")
    deck: t.BodyName = Field(DECK_BRICK, description="the brick that is the deck; default: `deck`")

    scalar_key: ClassVar[str] = "is"
    identifying_keys: ClassVar[tuple[str, ...]] = ("deck",)

    def judge(self, trace: Trace) -> ClaimResult:
        """Compare the largest overhang of all bricks."""
        if (found := deck_and_load(self.deck, trace)) is None:
            return ClaimResult(NOTHING, 0.0, "mm", passed=False)
        beyond, side, name = max(overhangs(*found))
        beyond = round(beyond, DIGITS)
        told = f"{mm(beyond)} by {name} towards {side}" if beyond > 0.0 else f"0 mm, {mm(abs(beyond))} inside"
        return within(self.within, max(beyond, 0.0), "mm", told)


@claim("weight", "the mass of the structure")
class Weight(Shorthand, ClaimKind):
    """The mass of all bricks, with the pallet if it is built."""

    within: t.WeightTolerance = Field(alias="is", description="accepted masses, or weights as a force")
    without: t.BodyNames | None = Field(None, description="bricks that do not count, such as [deck]; default: none")

    scalar_key: ClassVar[str] = "is"
    identifying_keys: ClassVar[tuple[str, ...]] = ("without",)

    def contradicts(self, other: "Weight") -> bool:
        return isinstance(self.within, MassTolerance) == isinstance(
            other.within, MassTolerance
        ) and super().contradicts(other)

    def judge(self, trace: Trace) -> ClaimResult:
        """Compare the sum of all bricks that are placed."""
        counted = [track for track in placed(trace) if track.brick.id not in (self.without or ())]
        mass = round(fsum(track.brick.mass for track in counted), DIGITS)
        if isinstance(self.within, MassTolerance):
            return within(self.within, mass, "kg", f"{mass:.6g} kg")
        force = mass * (trace.world.gravity if trace.world is not None else 0.0)
        return within(self.within, force, "N", f"{force:.6g} N")


@claim("centre_of_mass", "where the centre of mass of a load is on its pallet")
class CentreOfMass(AtLeastOneKey, ClaimKind):
    """The centre of mass of all bricks but the deck."""

    offset: t.LengthTolerance | None = Field(
        None, description="horizontal distance from the middle of the deck, in any direction"
    )
    height: t.LengthTolerance | None = Field(None, description="height above the underside of the deck")
    deck: t.BodyName = Field(DECK_BRICK, description="the brick that is the deck; default: `deck`")

    defaults: ClassVar[tuple[str, ...]] = ("deck",)
    identifying_keys: ClassVar[tuple[str, ...]] = ("deck",)

    def judge(self, trace: Trace) -> ClaimResult:
        """Compare the common centre of mass."""
        if (found := deck_and_load(self.deck, trace)) is None:
            return ClaimResult(NOTHING, 0.0, "mm", passed=False)
        deck, load = found
        x, y, z = centre_on_deck(deck, load)
        parts = []
        if self.offset is not None:
            told = f"offset {mm(hypot(x, y))} ({mm(x)} along, {mm(y)} across)"
            parts.append(within(self.offset, hypot(x, y), "mm", told))
        if self.height is not None:
            parts.append(within(self.height, z, "mm", f"height {mm(z)}"))
        return all_of(parts)
