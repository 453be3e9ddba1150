"""Checks of a compiled scenario: names, levels, neighbours, overlaps, slivers, contradictory claims, large margins."""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import ceil, inf
from typing import Final, Self

from stability.geometry.box import Box
from stability.geometry.box_distance import reach_between
from stability.geometry.compound import Compound
from stability.geometry.placed_shape import bounds_W
from stability.geometry.spatial_grid import Neighbours
from stability.geometry.vectors import SHORTEST, add, body_axes, dot
from stability.joints import on_one_grid, studs_meet
from stability.model import GROUND, BodyId, Brick, Pose, Vec3
from stability.problem import Placed
from stability.statics.assembly import LIGHTEST
from stackdsl.compiler.bricks import MAX_NAMED, ActionOrder, ResolvedBrick, WrittenBrick, later_names
from stackdsl.compiler.fit import MOST_INSIDE, CrowdedError, Fit, TimedShape, fits
from stackdsl.compiler.joints import Meeting, are_joined, idle_joints
from stackdsl.compiler.schedule import ResolvedScenario
from stackdsl.diagnostics import Diagnostic, Span, capped, did_you_mean
from stackdsl.language.bricks import PLAY
from stackdsl.language.claims.claim import Claim, Expectation
from stackdsl.language.claims.claim_kind import ClaimKind
from stackdsl.language.pallets import CLOSED, DECK_BRICK
from stackdsl.language.quantities import LENGTH, InputError, parse_quantity
from stackdsl.language.room_on_deck import Room, room_text
from stackdsl.language.schema import Scenario
from stackdsl.language.value_types import NameReference, named_in
from stackdsl.language.yaml.source import KeyPath, Source
from stackdsl.timeline import AccelerationTest
from stackdsl.wording import MILLIMETRES, mm, rounded_up
from stackdsl.work import HINT, most_bricks, most_points

# Names and levels.


def excessive_levels(built: ResolvedScenario, _scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report written levels that are more than one above the supports of the brick."""
    for brick in built.bricks:
        if brick.written.level is None or brick.written.of_layout or brick.footing.in_the_air:
            continue  # in the air, any written level is valid
        highest = max((built.bricks[other].level for other in brick.footing.on_boxes), default=0) + 1
        if brick.written.level > highest:
            where = "the ground" if highest == 1 else f"level {highest - 1}"
            message = f"brick '{brick.name}' stands on {where}, so its level cannot be {brick.written.level}"
            hint = f"write a level of at most {highest}, or remove `level`"
            yield Diagnostic("SD104", source.span_of((*brick.written.path, "level")), message, hint)


def duplicate_names(built: ResolvedScenario, _scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report bricks with the name of an earlier one."""
    first: dict[BodyId, ResolvedBrick] = {}
    for brick in built.bricks:
        other = first.setdefault(brick.name, brick)
        if other is not brick:
            there, here = source.span_of(other.written.path), source.span_of(brick.written.path)
            message = f"two bricks have the name '{brick.name}'; the other one is at {there.seen_from(here)}"
            named = all(each.written.path and each.written.path[-2:-1] == ("bricks",) for each in (brick, other))
            yield Diagnostic("SD203", here, message, "rename one" if named else "give the step or the brick a name")


def duplicate_missile_names(built: ResolvedScenario, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report thrown and dropped bricks with the name of another brick."""
    names = {brick.name for brick in built.bricks}
    for number, brick in built.missiles.items():
        if brick.id in names:
            span = source.span_of(("impacts", number, scenario.impacts[number].kind, "name"))
            yield Diagnostic("SD203", span, f"two bricks have the name '{brick.id}'", "rename one of them")
        names.add(brick.id)


def unknown_bricks(built: ResolvedScenario, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report names in impacts and claims that no brick has."""
    names, planes = [brick.name for brick in built.bricks], _planes(scenario)
    bodies = (*names, *(brick.id for brick in built.missiles.values()))
    bricks, all_bodies = set(bodies), {*bodies, *planes}
    impacts = (name for number, impact in enumerate(scenario.impacts) for name in named_in(impact, ("impacts", number)))
    for reference in (*impacts, *(reference for _, reference in _claimed(scenario))):
        if reference.name not in (all_bodies if reference.or_plane else bricks):
            candidates = (*bodies, *planes) if reference.or_plane else names  # missiles are no part of the structure
            hint = did_you_mean(reference.name, candidates) or f"the names of the bricks are {names[0]} to {names[-1]}"
            if reference.name == DECK_BRICK:
                hint = (
                    f"build the pallet, such as with `deck: {{size: EUR, surface: {CLOSED}}}` of an import; or {hint}"
                )
            yield Diagnostic("SD204", source.span_of(reference.path), f"there is no brick '{reference.name}'", hint)


def claims_about_removed_bricks(_built: ResolvedScenario, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report claims about the final state of bricks that are pulled out."""
    removed = {reference.name for impact in scenario.impacts for reference in impact.content.pulled_out}
    for claim, reference in _claimed(scenario):
        if reference.name in removed and not claim.content.allows_removed_bricks:
            message = f"brick '{reference.name}' is pulled out, so claims cannot refer to it"
            yield Diagnostic("SD204", source.span_of(reference.path), message, "remove this name")


def claims_about_missiles(built: ResolvedScenario, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report claims about thrown and dropped bricks, which are not part of the structure."""
    missiles = {
        built.missiles[number].id: impact.content.missile.how
        for number, impact in enumerate(scenario.impacts)
        if impact.content.missile is not None
    }
    for _, reference in _claimed(scenario):
        if reference.name in missiles and not reference.or_plane:
            arrival = missiles[reference.name]
            message = (
                f"brick '{reference.name}' is {arrival} and not part of the structure, so claims cannot refer to it"
            )
            yield Diagnostic(
                "SD204",
                source.span_of(reference.path),
                message,
                "remove this name, or write the name of a brick of the structure",
            )


def _planes(scenario: Scenario) -> tuple[BodyId, ...]:
    return (GROUND, *(f"wall{number}" for number in range(1, len(scenario.world.walls) + 1)))


def _claimed(scenario: Scenario) -> Iterator[tuple[Claim, NameReference]]:
    """Yield the brick names in all claims."""
    for key, claims in (("expect", scenario.expect), ("truth", scenario.truth)):
        for number, claim in enumerate(claims):
            yield from ((claim, named) for named in named_in(claim, (key, number)))


# The requirements of all claims together.


# Defaults, unless the scenario or a claim sets a duration.
HOLD = 2.0  # [s] simulated after the last action
AFTERMATH = 1.0  # [s] simulated after the beginning of a collapse; twice the fall of a plank from a metre


@dataclass(frozen=True, slots=True)
class RunRequirements:
    """The results that a run must produce."""

    hold: float  # simulated time after the last action [s]
    followed: float  # simulated time after the beginning of a collapse [s]
    watched: bool  # results that only a simulated motion gives
    margins: tuple[str, ...]  # of the proof, such as `tilt`
    reported_margins: tuple[str, ...]  # also of the proof, but needed by no claim; only for few bricks, where cheap
    closely: bool  # the onset of a fall, or the final positions
    measures: tuple[str, ...]  # measurements that are off by default, such as `sway`
    tests: tuple[AccelerationTest, ...]  # of the finished structure


def requirements_of(scenario: Scenario) -> RunRequirements:
    """Return the requirements of a scenario and all its claims."""
    claims = [claim.content for claim in (*scenario.expect, *scenario.truth)]
    spans = [span for span in (scenario.watch, *(claim.needed_hold for claim in claims)) if span is not None]
    return RunRequirements(
        hold=max(spans, default=HOLD),
        followed=scenario.watch or AFTERMATH,
        watched=scenario.watch is not None
        or scenario.world.shake is not None
        or any(step.place is not None for step in scenario.build)
        or any(impact.content.lasts for impact in scenario.impacts)
        or not scenario.expect
        or not all(claim.needs_statics for claim in claims),
        margins=tuple(sorted({margin for claim in claims for margin in claim.needed_margins})),
        reported_margins=tuple(sorted({margin for claim in claims for margin in claim.reported_margins})),
        closely=any(claim.needs_dense_recording for claim in claims),
        measures=tuple(sorted({measure for claim in claims for measure in claim.needed_measures})),
        tests=tuple(dict.fromkeys(test for claim in claims for test in claim.needed_tests)),
    )


# Bricks of several parts, which few systems move.


EXACT: Final = "exact"


def bricks_of_several_parts(built: ResolvedScenario, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report the systems that do not move bricks of several parts."""
    shapes = (brick.written.shape for brick in built.bricks)
    flying = (missile.shape for missile in built.missiles.values())
    if any(isinstance(shape, Compound) for shape in (*shapes, *flying)):
        for system in (system for system in scenario.systems if system != EXACT):
            message = f"the system '{system}' does not move bricks of several parts"
            yield Diagnostic("SD211", source.key_span_of(("systems",)), message, f"write `systems: [{EXACT}]`")


# Contradictory claims: on one system, a brick cannot be claimed both to stand and to fall.


def contradictions(built: ResolvedScenario, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report expectations that contradict an earlier one."""
    levels, hold = {brick.name: brick.level for brick in built.bricks}, requirements_of(scenario).hold
    places = {name: number for number, name in enumerate(levels)}
    meanings = [_ClaimedBricks.of(claim, levels, places, hold) for claim in scenario.expect]
    for number, claim in enumerate(scenario.expect):
        for before, earlier in enumerate(scenario.expect[:number]):
            if not meanings[number].excludes(meanings[before]):
                continue
            shared = [name for name in scenario.systems if _is_of(claim, name) and _is_of(earlier, name)]
            if shared:
                there = source.key_span_of(("expect", before, earlier.kind))
                here = source.key_span_of(("expect", number, claim.kind))
                other = f"`{earlier.kind}` at {there.seen_from(here)}"
                message = f"this claim and {other} contradict each other on {', '.join(shared)}"
                yield Diagnostic("SD104", here, message, "remove one of them, or add `system:` to both")
                break


def excessive_counts(built: ResolvedScenario, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report claims about more levels or bricks than are built: their verdict would not depend on the run."""
    resolved_scenario = {"bricks": len(built.bricks), "levels": built.levels}
    for key, claims in (("expect", scenario.expect), ("truth", scenario.truth)):
        for number, claim in enumerate(claims):
            for count in claim.content.counts():
                most = resolved_scenario[count.noun]
                if count.least > most:
                    message = f"the claim needs {count.least:g} {count.noun}, but the structure has {most}"
                    span = source.span_of((key, number, claim.kind, count.key))
                    yield Diagnostic("SD205", span, message, f"reduce the number to at most {most}, or add bricks")


def _is_of(claim: Expectation, system: str) -> bool:
    return claim.system is None or system in claim.system


@dataclass(frozen=True, slots=True)
class _ClaimedBricks:
    """The bricks that stand and fall by one claim, computed once to compare it with every other claim.

    A set of bricks is an integer with one bit per brick, since a thousand claims about ten thousand bricks must fit
    into memory.
    """

    claim: ClaimKind
    alone: int  # bricks that must all fall
    together: Sequence[int]  # groups of bricks; at least one of each group must fall
    staying: int | None  # bricks that must stand; None if there are none

    @classmethod
    def of(cls, claim: Expectation, levels: Mapping[BodyId, int], places: Mapping[BodyId, int], hold: float) -> Self:
        """Return the bricks of a claim; `places` has the index of each brick."""
        content, alone, together = claim.content, set[BodyId](), list[int]()
        for group in content.must_fall(levels):
            if len(group) == 1:
                alone.update(group)
            else:
                together.append(_bits(group, places))
        staying = content.must_stand(levels, hold)
        return cls(content, _bits(alone, places), together, None if staying is None else _bits(staying, places))

    def excludes(self, other: "_ClaimedBricks") -> bool:
        """Whether the two claims contradict each other."""
        if type(self.claim) is type(other.claim):
            return self.claim.contradicts(other.claim)
        return self._fells(other) or other._fells(self)

    def _fells(self, other: "_ClaimedBricks") -> bool:
        """Whether a brick must fall by this claim and stand by the other."""
        staying = other.staying
        if staying is None:
            return False
        return bool(self.alone & staying) or any(group & staying == group for group in self.together)


def _bits(bricks: Collection[BodyId], places: Mapping[BodyId, int]) -> int:
    """Return the integer with one bit for each of the bricks."""
    bits = bytearray(len(places) // 8 + 1)
    for brick in bricks:
        place = places[brick]
        bits[place >> 3] |= 1 << (place & 7)
    return int.from_bytes(bits, "little")


# Bricks inside others, or in the air.


USUAL_DIGITS, ALL_DIGITS = 4, 17  # digits of a length in a message, and enough to distinguish any two lengths


def misfits(built: ResolvedScenario, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report bricks inside others or in the air; once per code and position, since a layout has one position."""
    reported: set[tuple[str, KeyPath]] = set()
    bricks = built.in_order
    try:
        results = fits(_sited(bricks, built), built.planes)
    except CrowdedError as error:
        yield crowded(bricks[error.index].written, source)
        return
    if are_joined(built, scenario) and not any(fit.overlaps for fit in results):
        yield from idle_joints(list(_meetings(bricks, results, built)), built, scenario, source)
    is_crowded = sum(fit.overlaps for fit in results) > MOST_INSIDE  # then supports may be missing from the index
    studs = {
        index: (code, message, hint)
        for index, code, message, hint in (*_off_plate(bricks, results, built, scenario), *_off_studs(bricks, results))
    }
    joined = are_joined(built, scenario)
    for index, (brick, fit) in enumerate(zip(bricks, results, strict=True)):
        mistake = _misfit(fit, brick, built, scenario, source, joined) if fit.overlaps or not is_crowded else None
        mistake = mistake or studs.get(index)
        if mistake is not None and (mistake[0], brick.written.path) not in reported:
            reported.add((mistake[0], brick.written.path))
            yield Diagnostic(mistake[0], source.span_of(brick.written.path), *mistake[1:])


def _meetings(bricks: Sequence[ResolvedBrick], results: Sequence[Fit], built: ResolvedScenario) -> Iterator[Meeting]:
    """Yield the bodies that touch when they are set down."""
    for brick, fit in zip(bricks, results, strict=True):
        for other in (bricks[number] for number in (*fit.on_boxes, *fit.beside_boxes)):
            both = (brick, other)
            until = min((each.removed.time for each in both if each.removed is not None), default=inf)
            since = max(each.placed.time for each in both)
            yield Meeting((brick.name, other.name), _placed(brick), _placed(other), since, until)
        until = inf if brick.removed is None else brick.removed.time
        for number in (*fit.on_planes, *fit.beside_planes):
            names = (brick.name, built.planes[number].id)
            yield Meeting(names, _placed(brick), None, brick.placed.time, until)


def _placed(brick: ResolvedBrick) -> Placed:
    """Return a brick in place, for the grid of its studs, which is independent of its mass."""
    return Placed(Brick(brick.name, brick.written.shape, 1.0), brick.written.pose)


def crowded(brick: WrittenBrick, source: Source) -> Diagnostic:
    """Return the diagnostic for a brick with too many neighbours to compare."""
    message = "too many bricks are close together here, so the search for contacts takes too long"
    hint = "use fewer bricks, or align long ones with the axes, so that fewer bounding boxes overlap"
    return Diagnostic("SD206", source.span_of(brick.path), message, hint)


def _sited(bricks: Sequence[ResolvedBrick], built: ResolvedScenario) -> list[TimedShape]:
    """Return bricks with the order numbers of their placement and removal."""
    moments = sorted({*(brick.placed for brick in bricks), *built.impacts})
    turns = {moment: float(turn) for turn, moment in enumerate(moments)}
    return [
        TimedShape(
            turns[brick.placed],
            brick.written.shape,
            brick.written.pose,
            inf if brick.removed is None else turns[brick.removed],
        )
        for brick in bricks
    ]


DELETE: Final = "delete one of them if it is there twice"
AXES: Final[Mapping[str, Vec3]] = {
    **{"+x": (1.0, 0.0, 0.0), "+y": (0.0, 1.0, 0.0), "+z": (0.0, 0.0, 1.0)},
    **{"-x": (-1.0, 0.0, 0.0), "-y": (0.0, -1.0, 0.0), "-z": (0.0, 0.0, -1.0)},
}
SPACINGS: Final = ("spacing", "gap")  # keys of layouts for the distance between bricks
TIDY: Final = 0.01  # [m] suggested origins beside others are multiples of this
ON_AXIS: Final = 0.9999  # cosine of a direction that counts as that of an axis


def _misfit(  # noqa: PLR0913, PLR0917 -- all that a message names
    fit: Fit, brick: ResolvedBrick, built: ResolvedScenario, scenario: Scenario, source: Source, joined: bool
) -> tuple[str, str, str] | None:
    of_layout = brick.written.of_layout
    if fit.overlaps:
        bricks = built.in_order
        other = bricks[fit.overlaps_box].written if fit.overlaps_box is not None else None
        name = f"brick '{bricks[fit.overlaps_box].name}'" if fit.overlaps_box is not None else ""
        plane = built.planes[fit.overlaps_plane].id if fit.overlaps_plane is not None else ""
        message = f"brick '{brick.name}' is {mm(fit.depth)} inside {name or plane}"
        towards = next((f" towards {name}" for name, axis in AXES.items() if dot(axis, fit.way_out_W) > ON_AXIS), "")
        hint = f"move it by at least {mm(fit.depth)}{towards}"
        if not of_layout:
            same = other is not None and _bounds((brick.written,)) == _bounds((other,))
            twice = same and other is not None and brick.written.mass == other.mass
            message = f"{message}, at the same place" if same else message
            if other is not None and (on_deck := _on_deck(brick, other, bricks, source)):
                return "SD201", message, f"{on_deck}; or {DELETE}" if twice else on_deck
            if same:
                return "SD201", message, f"{DELETE}, or move it" if twice else "move one of them"
            if towards == " towards +z":
                hint = " or ".join(_supported_places(brick, other, fit.depth, built, source)) or hint
            return "SD201", message, hint
        if other is None or brick.written.step >= len(scenario.build):
            return "SD201", message, f"{hint}, or place the layout elsewhere with `origin`"
        if other.path == brick.written.path:
            return "SD201", f"{message}, of the same layout", _wider(brick.written, other, scenario)
        return "SD201", message, _elsewhere(brick.written, other, bricks, scenario)
    may_be_joined = joined and bool(fit.beside_boxes or fit.beside_planes)
    if fit.in_the_air and not brick.written.drop and not may_be_joined:
        above = "" if fit.clearance == inf else f"; the nearest body below is {_distances(fit.clearance, fit.reach)}"
        held = "with or after the brick whose joint holds it, " * joined
        hint = f"place it on a support, {held}or write `drop: true` to let it fall"
        if of_layout:
            hint = "change the dimensions or the `origin` of the layout so that every brick has a support"
        return "SD202", f"brick '{brick.name}' has no support{above}", hint
    return None


def _off_studs(bricks: Sequence[ResolvedBrick], results: Sequence[Fit]) -> Iterator[tuple[int, str, str, str]]:
    """Yield the mistakes of bricks off the grid of the studs above or below them, of earlier bricks, by index."""
    if all(brick.written.kind.studs is None for brick in bricks):
        return
    placed = list(map(_placed, bricks))
    for index, (brick, fit) in enumerate(zip(bricks, results, strict=True)):
        studs = brick.written.kind.studs
        others = (*fit.on_boxes, *fit.beside_boxes) if studs is not None else ()
        for number in (number for number in others if number < index and bricks[number].written.kind.studs == studs):
            lower = min(index, number, key=lambda each: placed[each].pose.position_W[2])
            if bricks[lower].written.kind.smooth:
                continue
            if studs is not None and not studs_meet(placed[index], placed[number], studs.pitch):
                message = f"brick '{brick.name}' is off the studs of brick '{bricks[number].name}'"
                hint = f"move it onto the grid of {mm(studs.pitch)}, as `stud` does, or use a brick without studs"
                yield index, "SD201", message, hint
                break


def _off_plate(
    bricks: Sequence[ResolvedBrick], results: Sequence[Fit], built: ResolvedScenario, scenario: Scenario
) -> Iterator[tuple[int, str, str, str]]:
    """Yield the mistakes of bricks beside the base plate or off its studs, by index.

    A plate has studs from the origin on; ground of no size has them where those of the first brick are.
    """
    ground = scenario.world.ground
    standing = [
        index for index, fit in enumerate(results) if any(built.planes[number].id == GROUND for number in fit.on_planes)
    ]
    if ground.studs is None:
        return
    pitch = ground.studs.pitch
    corner = Placed(Brick(GROUND, Box((pitch, pitch, pitch)), 1.0), Pose((0.5 * pitch, 0.5 * pitch, 0.0)))
    first = None if ground.plate is None else corner
    for index in standing:
        brick = bricks[index]
        own = _placed(brick)
        low_W, high_W = bounds_W(own.brick.shape, own.pose)
        if ground.plate is not None and not all(
            low > -PLAY * pitch and high < (count + PLAY) * pitch
            for low, high, count in zip(low_W, high_W, ground.plate, strict=False)
        ):
            along, across = ground.plate
            message = f"brick '{brick.name}' is not all on the base plate of {along} x {across} studs"
            yield index, "SD202", message, f"move it between [0, 0] and [{mm(along * pitch)}, {mm(across * pitch)}]"
        elif brick.written.kind.studs == ground.studs:
            first = first or own
            if not on_one_grid(first, own, pitch):
                stands = "" if first is corner else f", on which brick '{first.brick.id}' stands"
                message = f"brick '{brick.name}' is off the studs of the ground{stands}"
                yield index, "SD201", message, f"move it onto the grid of {mm(pitch)}, as `stud` does"


def _on_deck(brick: ResolvedBrick, other: WrittenBrick, bricks: Sequence[ResolvedBrick], source: Source) -> str:
    """Return how an imported box fits on its deck; empty without a deck, or if it lies too low.

    A mistyped place is the usual cause, so the row comes first, and moves that also move other boxes come last.
    """
    step = brick.written.path[:2]
    if step not in source.decks or other.path[:2] != step:
        return ""
    load = [each for each in bricks if each.written.path[:2] == step]
    room = Room([bounds_W(each.written.shape, each.written.pose) for each in load], source.decks[step])
    number = load.index(brick)
    if not room.is_crowded(number):
        return ""
    row = f"check the place of '{brick.name}' in line {source.span_of(brick.written.path).line}"
    alone = room.move_to_only_free_place(number)
    free = f": the only free place of its size in this layer is {alone}" if alone else ""
    moves = room_text(room, number, [f"'{each.name}'" for each in load])
    return f"{row}{free}; or {moves}"


MOST_TRIED: Final = 500  # bricks of a scene in which places for one brick are tried; each takes milliseconds


def _supported_places(
    brick: ResolvedBrick, other: WrittenBrick | None, depth: float, built: ResolvedScenario, source: Source
) -> Iterator[str]:
    """Yield keys that place a single brick on top of, or beside, the body that it is inside of. Each is tried."""
    written = source.values
    for key in brick.written.path:
        written = written[key]  # type: ignore[assignment, index]  # a path of the source
    at = written.get("at") if isinstance(written, dict) else None
    try:
        place = [parse_quantity(each, LENGTH) for each in at] if isinstance(at, list) else []
    except InputError:  # an expression
        return
    here = source.value_spans.get((*brick.written.path, "at"))
    is_imported = here is None or here.file != source.span_of(brick.written.path).file
    if is_imported or len(place) != len(AXES) // 2 or len(built.in_order) > MOST_TRIED:
        return
    sited, index = _sited(built.in_order, built), built.in_order.index(brick)
    resting = sited[index]
    moves = [("`at` is the centre of the brick: write", (0.0, 0.0, depth))]
    if other is not None:
        shift, towards = _way_aside(brick.written, other)
        moves.append(("beside it", (shift * AXES[towards][0], shift * AXES[towards][1], 0.0)))
    for way, move in moves:
        sited[index] = replace(resting, pose=replace(resting.pose, position_W=add(resting.pose.position_W, move)))
        fit = fits(sited, built.planes)[index]
        if not fit.overlaps and not fit.in_the_air:
            yield f"{way} `at: [{', '.join(mm(each, 9) for each in add((place[0], place[1], place[2]), move))}]`"


def _apart(brick: WrittenBrick, other: WrittenBrick) -> str:
    """Return a horizontal shift that ends the overlap of two bricks: `94.2 mm towards +x`."""
    shift, towards = _way_aside(brick, other)
    return f"{rounded_up(MILLIMETRES * shift, USUAL_DIGITS)} mm towards {towards}"


def _way_aside(brick: WrittenBrick, other: WrittenBrick) -> tuple[float, str]:
    """Return the least horizontal shift [m] that ends the overlap of two bricks, and its direction."""
    (low, high), (other_low, other_high) = _bounds((brick,)), _bounds((other,))
    ways = [
        (way, towards)
        for axis, (plus, minus) in enumerate((("+x", "-x"), ("+y", "-y")))
        for way, towards in ((other_high[axis] - low[axis], plus), (high[axis] - other_low[axis], minus))
    ]
    return min(ways, key=lambda each: (round(each[0], 9), each[1]))


def _wider(brick: WrittenBrick, other: WrittenBrick, scenario: Scenario) -> str:
    """Return the remedy for a layout whose own bricks overlap."""
    layout = scenario.build[brick.step].layout
    keys = [key for key in SPACINGS if layout is not None and key in type(layout[1]).model_fields]
    apart = _apart(brick, other).partition(" towards")[0]
    if keys:
        return f"increase `{keys[0]}` by at least {apart}"
    return f"place its bricks at least {apart} further apart, or use fewer of them"


def _elsewhere(brick: WrittenBrick, other: WrittenBrick, bricks: Sequence[ResolvedBrick], scenario: Scenario) -> str:
    """Return the remedy for a layout inside bricks of another step: beside these, or on top of them."""
    layout = scenario.build[brick.step].layout
    assert layout is not None  # the caller knows that the brick is of a layout
    x, y, z = layout[1].origin
    own = _bounds([each.written for each in bricks if each.written.path == brick.path])
    others = _bounds([each.written for each in bricks if each.written.step == other.step])
    beside = TIDY * ceil((x + others[1][0] - own[0][0]) / TIDY + 1e-9)
    on_top = z + others[1][2] - own[0][2]
    return (
        f"to place the layout beside, write `origin: [{mm(beside)}, {mm(y)}, {mm(z)}]`; "
        f"to place it on top, `origin: [{mm(x)}, {mm(y)}, {mm(on_top, 9)}]`"
    )


def _bounds(bricks: Iterable[WrittenBrick]) -> tuple[Vec3, Vec3]:
    """Return the least and largest coordinates of bricks."""
    lows, highs = zip(*(bounds_W(brick.shape, brick.pose) for brick in bricks), strict=True)
    low = [min(each[axis] for each in lows) for axis in range(3)]
    high = [max(each[axis] for each in highs) for axis in range(3)]
    return (low[0], low[1], low[2]), (high[0], high[1], high[2])


def _distances(clearance: float, reach: float) -> str:
    """Return the text of a distance and of the largest allowed one, with enough digits to distinguish them."""
    texts = ((mm(clearance, digits), mm(reach, digits)) for digits in range(USUAL_DIGITS, ALL_DIGITS + 1))
    away, most = next(pair for pair in texts if pair[0] != pair[1])
    return f"{away} away; the largest gap that counts as contact is {most}"


# Bricks placed on or beside others, which must be present and still at their written positions.


def missing_neighbours(built: ResolvedScenario, _scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report bricks that are placed on or beside a brick that does not come before them."""
    lost = [brick for brick in built.bricks if brick.written.lost is not None]
    if not lost:
        return
    later = later_names([brick.written for brick in built.bricks])
    names = [brick.name for brick in built.bricks if brick.written.lost is None]
    for brick in lost:
        error, span = brick.written.lost, _span(brick, source)
        assert error is not None  # as `lost` has only such bricks
        if error.too_costly:
            message = f"the search for '{error.name}' must recompute more than {MAX_NAMED} automatic names"
            yield Diagnostic("SD206", span, message, "give names to the bricks on or beside which others are placed")
            return
        elif error.name in later:
            there = source.span_of(later[error.name].path)
            if later[error.name].path == brick.written.path:
                yield Diagnostic(
                    "SD204", span, f"brick '{error.name}' is placed on or beside itself", "name another brick"
                )
                continue
            message = f"brick '{error.name}' is placed later, at {there.seen_from(span)}"
            yield Diagnostic("SD204", span, message, "refer to an earlier brick, or place that brick first")
        else:
            hint = did_you_mean(error.name, [*names, GROUND]) or "refer to an earlier brick"
            yield Diagnostic("SD204", span, f"no earlier brick has the name '{error.name}'", hint)


def misplaced_bricks(built: ResolvedScenario, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report bricks placed by absent ones; if there are none, report bricks that do not fit."""
    moved = capped(_moved_neighbours(built, scenario, source))
    yield from moved or misfits(built, scenario, source)


def _moved_neighbours(built: ResolvedScenario, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report bricks placed on or beside one that is absent at that time, or whose position is unknown."""
    if not any(brick.written.placed_by for brick in built.bricks):
        return
    hit = _hit(built, scenario)
    for brick in built.bricks:
        for number in brick.written.placed_by:
            other = built.bricks[number]
            if (reason := _why_unknown(other, brick.placed, hit)) is not None:
                message = (
                    f"brick '{brick.name}' is placed relative to '{other.name}' at {brick.placed.time:g} s, {reason}"
                )
                hint = "refer to another brick, use `at` with a position, or place it at another time"
                yield Diagnostic("SD204", _span(brick, source), message, hint)
                break


def _why_unknown(other: ResolvedBrick, moment: ActionOrder, hit: Mapping[BodyId, ActionOrder]) -> str | None:
    """Return why the position of a brick at a moment is unknown; None if it is at its written position."""
    if other.written.drop:
        return "which is dropped, so its position is unknown before the run"
    if other.placed > moment:
        return f"which is not placed before {other.placed.time:g} s"
    if other.removed is not None and other.removed <= moment:
        return f"which is pulled out at {other.removed.time:g} s"
    if other.name in hit and hit[other.name] <= moment:
        return f"which is hit at {hit[other.name].time:g} s, so its position is unknown before the run"
    return None


def _hit(built: ResolvedScenario, scenario: Scenario) -> Mapping[BodyId, ActionOrder]:
    """Return the moment of the first impact on each brick that may move it."""
    first: dict[BodyId, ActionOrder] = {}
    for moment, impact in sorted(zip(built.impacts, scenario.impacts, strict=True), key=lambda timed: timed[0]):
        if impact.content.slid_in is None:
            for reference in named_in(impact.content):
                first.setdefault(reference.name, moment)
    return first


def _span(brick: ResolvedBrick, source: Source) -> Span:
    key = "beside" if (*brick.written.path, "beside") in source.value_spans else "on"
    return source.span_of((*brick.written.path, key))


# Cut bricks, as at the ends of a wall, that are too small for statics.


def slivers(built: ResolvedScenario, _scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report one sliver of each layout; validation reports whole bricks that are too small."""
    reported: set[KeyPath] = set()
    for brick in built.bricks:
        written = brick.written
        if (written.shape.least_thickness < SHORTEST or written.mass < LIGHTEST) and written.path not in reported:
            reported.add(written.path)
            side = written.shape.least_thickness
            message = f"the layout cuts brick '{brick.name}' too small: {written.mass:.3g} kg, side {side:.3g} m"
            hint = f"change the dimensions of the layout; the minimum is {LIGHTEST:g} kg and {SHORTEST:g} m"
            yield Diagnostic("SD104", source.span_of(written.path), message, hint)


# Margins with too large programs: of too many bricks, or too many contact points.


ALONG: Final = 1e-6  # tolerance of the cosine of the angle between parallel or perpendicular sides
CUT: Final = 2  # additional corners of the intersection of two rectangles that are rotated against each other


def too_many_in_margins(bricks: int, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report margins of too many bricks; called before any brick is built."""
    yield from _beyond(most_bricks, bricks, "bricks", scenario, source)


def too_many_points(built: ResolvedScenario, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report margins of bricks with too many possible contact points; a lattice has far more of these than a wall."""
    claims = (*scenario.expect, *scenario.truth)
    if any(most_points(margin) is not None for claim in claims for margin in claim.content.needed_margins):
        points, near = 0, Neighbours[int]()
        for number, brick in enumerate(built.bricks):
            low_W, high_W = bounds_W(brick.written.shape, brick.written.pose)
            beside = near.around(low_W, high_W, reach_between(brick.written.shape.least_thickness))
            points += sum(_points(brick.written, built.bricks[other].written) for other in beside)
            near.add(number, low_W, high_W)
        yield from _beyond(most_points, points, "contact points", scenario, source)


def _points(one: WrittenBrick, other: WrittenBrick) -> int:
    """Return the largest number of contact points of two bricks: the corners of the intersection of two faces."""
    most = max(len(face.corners) for brick in (one, other) for face in brick.shape.faces)
    turned = abs(dot(body_axes(one.pose.orientation)[0], body_axes(other.pose.orientation)[0]))
    return most if turned < ALONG or turned > 1.0 - ALONG else most + CUT


def _beyond(
    most_of: Callable[[str], int | None], count: int, noun: str, scenario: Scenario, source: Source
) -> Iterator[Diagnostic]:
    for key, claims in (("expect", scenario.expect), ("truth", scenario.truth)):
        for number, claim in enumerate(claims):
            for margin in sorted(claim.content.needed_margins):
                most = most_of(margin)
                if most is not None and count > most:
                    limit = f"the maximum is {most}"
                    message = (
                        f"the computation of the margin `{margin}` for up to {count} {noun} takes too long; {limit}"
                    )
                    hint = f"claim `verdict: stable` or `margin: {{friction: ...}}` instead, use fewer bricks, {HINT}"
                    yield Diagnostic("SD206", source.key_span_of((key, number, claim.kind)), message, hint)
