"""Ties of a scenario, in W, and refusals of what is not judged with them."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import cos, sin
from typing import Final

from stability.geometry.placed_shape import distance_outside, in_place, reach_W
from stability.geometry.round_solid import RoundSolid
from stability.geometry.vectors import add, dot, norm, rotate, scale, subtract
from stability.model import Brick, Vec3
from stability.problem import Placed
from stability.ties import Cable, crosses, loop_around, pulls_of, straight_between
from stability.ties import Tie as TieOfBricks
from stackdsl.compiler.at_rest import what_moves
from stackdsl.compiler.bricks import ResolvedBrick
from stackdsl.compiler.fit import OVERLAP
from stackdsl.compiler.joints import bodies_by_name
from stackdsl.compiler.schedule import ResolvedScenario, tilt_of
from stackdsl.diagnostics import Diagnostic, did_you_mean
from stackdsl.language.schema import Scenario
from stackdsl.language.ties import ALL, Tie
from stackdsl.language.yaml.source import KeyPath, Source
from stackdsl.trace import USED_STRENGTH, is_load
from stackdsl.wording import mm

SYSTEM: Final = "exact"  # the only system that judges ties
NOT_MODELLED: Final = "ties are judged at rest only"
MARGINS: Final = frozenset({"load_factor", "acceleration"})  # also of ties of unknown tension
MARGINS_OF_KNOWN: Final = MARGINS | {"friction", USED_STRENGTH}
UP: Vec3 = (0.0, 0.0, 1.0)


def ties_of(built: ResolvedScenario, scenario: Scenario) -> tuple[TieOfBricks, ...]:
    """Return the ties, in W."""
    return tuple(_tie(tie, number, built, scenario) for number, tie in enumerate(scenario.ties))


def name_of(tie: Tie, number: int) -> str:
    """Return the name of a tie in reports."""
    return tie.name or f"tie {number + 1}"


def _tie(tie: Tie, number: int, built: ResolvedScenario, scenario: Scenario) -> TieOfBricks:
    bricks, tilt = _placed(_tied(tie, built, scenario)), tilt_of(scenario)
    cable = _cable(tie, bricks)
    pulls = tuple(replace(pull, force=rotate(tilt, pull.force)) for pull in pulls_of(cable, bricks))
    course_W = tuple(rotate(tilt, point) for point in cable.course_W)
    names = frozenset(placed.brick.id for placed in bricks)
    return TieOfBricks(name_of(tie, number), names, pulls, tie.least, tie.most, course_W)


def _tied(tie: Tie, built: ResolvedScenario, scenario: Scenario) -> list[ResolvedBrick]:
    """Return the bricks that a tie goes around, or both that it connects, in the order of their names."""
    bodies = bodies_by_name(built, scenario)
    if tie.between is not None:
        by_name = {brick.name: brick for brick in built.bricks}
        return [by_name[next(iter(bodies[name]))] for name in tie.between]
    names = {body for name in tie.around or () for body in bodies.get(name, ())}
    everything = ALL in (tie.around or ()) and ALL not in bodies
    return [brick for brick in built.bricks if everything or brick.name in names]


def _placed(bricks: Sequence[ResolvedBrick]) -> list[Placed]:
    return [Placed(Brick(each.name, each.written.shape, each.written.mass), each.written.pose) for each in bricks]


def _plane(tie: Tie, bricks: Sequence[Placed]) -> tuple[Vec3, float]:
    """Return the normal of the plane of a loop, and its offset from the origin [m]."""
    if tie.along is None:
        return UP, tie.height or 0.0
    x, y = _line(tie.along)
    normal = (-y, x, 0.0)
    return normal, _middle(bricks, normal) + (tie.offset or 0.0)


def _line(bearing: float) -> tuple[float, float]:
    # Rounded to digits on which all processors agree.
    return round(cos(bearing), 15), round(sin(bearing), 15)


def _middle(bricks: Sequence[Placed], direction: Vec3) -> float:
    """Return the middle of bricks along a direction [m]."""
    ends = [
        (
            dot(each.pose.position_W, direction) - reach_W(each.brick.shape, each.pose, scale(-1.0, direction)),
            dot(each.pose.position_W, direction) + reach_W(each.brick.shape, each.pose, direction),
        )
        for each in bricks
    ]
    return 0.5 * (min(low for low, _ in ends) + max(high for _, high in ends))


def _cable(tie: Tie, bricks: Sequence[Placed]) -> Cable:
    if tie.between is not None:
        one, other = bricks
        first, last = _ends(tie, bricks)
        return straight_between(one.brick.id, first, other.brick.id, last)
    normal, offset = _plane(tie, bricks)
    return loop_around(bricks, normal, offset, list(_anchors(tie, bricks, normal, offset)))


def _ends(tie: Tie, bricks: Sequence[Placed]) -> tuple[Vec3, Vec3]:
    """Return the ends of a straight tie."""
    one, other = bricks
    return tie.points or (one.pose.position_W, other.pose.position_W)


def _place_text(point: Vec3) -> str:
    return f"[{', '.join(mm(part) for part in point)}]"


def _anchors(tie: Tie, bricks: Sequence[Placed], normal: Vec3, offset: float) -> Iterator[Vec3]:
    """Yield the places on the ground where a tie ends."""
    if tie.along is not None and tie.anchors is not None:
        along = (*_line(tie.along), 0.0)
        middle = _middle(bricks, along)
        for place in tie.anchors:
            yield add(scale(middle + place, along), scale(offset, normal))


# Mistakes.


def invalid_ties(built: ResolvedScenario, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report ties of unknown bricks, ties that hold nothing together, and what is not judged with ties."""
    seen: dict[str, KeyPath] = {}
    for number, tie in enumerate(scenario.ties):
        path: KeyPath = ("ties", number)
        name = name_of(tie, number)
        if name in seen:
            there = source.span_of(seen[name]).seen_from(source.span_of(path))
            yield Diagnostic(
                "SD203", source.span_of(path), f"there is a tie '{name}' already, at {there}", "rename one"
            )
        seen[name] = path
        wrong = list(_unknown(tie, path, built, scenario, source))
        yield from wrong or _misplaced(tie, name, path, built, scenario, source)
    if scenario.ties:
        yield from _unjudged(built, scenario, source)


def _unknown(
    tie: Tie, path: KeyPath, built: ResolvedScenario, scenario: Scenario, source: Source
) -> Iterator[Diagnostic]:
    bodies, planes = bodies_by_name(built, scenario), {plane.id for plane in built.planes}
    for place, name in enumerate(tie.around or tie.between or ()):
        span = source.span_of((*path, tie.kind, place))
        if name in planes:
            hint = "name the bricks, and add `anchors: [-500 mm, 500 mm]` to an upright tie that ends at the ground"
            yield Diagnostic("SD104", span, f"a tie goes around bricks, not around '{name}'", hint)
        elif not bodies.get(name) and not (name == ALL and tie.around):
            others = sorted(other for other, bricks in bodies.items() if bricks and other not in planes)
            hint = did_you_mean(name, others) or "write the name of a brick, a step or a kind of brick, or `all`"
            yield Diagnostic("SD204", span, f"there is no brick, step or kind of brick '{name}' here", hint)
        elif tie.between and len(bodies[name]) > 1:
            message = f"'{name}' stands for {len(bodies[name])} bricks; a tie is `between` two single ones"
            yield Diagnostic("SD104", span, message, "write the name of one brick, or use `around`")
    if tie.between and bodies.get(tie.between[0]) == bodies.get(tie.between[1]):
        span = source.span_of((*path, "between"))
        yield Diagnostic("SD104", span, "both ends of the tie are at one brick", "write two different bricks")


def _misplaced(  # noqa: PLR0913, PLR0917 -- a tie, and where it is written
    tie: Tie, name: str, path: KeyPath, built: ResolvedScenario, scenario: Scenario, source: Source
) -> Iterator[Diagnostic]:
    tied = _tied(tie, built, scenario)
    span = source.span_of((*path, tie.kind))
    for brick in tied:
        if brick.removed is not None:
            message = f"the tie '{name}' holds brick '{brick.name}', which is pulled out"
            hint = "pull out another brick, or leave this one out of the tie: ties do not come off"
            yield Diagnostic("SD214", span, message, hint)
            return
    bricks = _placed(tied)
    if tie.between is not None:
        yield from _outside(tie, path, bricks, source)
        return
    cable = _cable(tie, bricks)
    if not cable.points:
        at = f"at a height of {mm(tie.height or 0.0)}" if tie.along is None else "there"
        message = f"the tie '{name}' meets none of its bricks {at}"
        key = "height" if tie.along is None else "offset" if tie.offset is not None else "along"
        yield Diagnostic("SD207", source.span_of((*path, key)), message, f"write `{key}` such that the loop meets them")
        return
    held = sorted({each.body for each in cable.points})
    if len(held) == 1 and tie.anchors is None:
        message = f"the tie '{name}' pulls at '{held[0]}' alone, so it holds nothing together"
        below = ", such as those below it, or add `anchors` on the ground" if tie.along is not None else " beside it"
        hint = f"name also the bricks that it ties this one to{below}"
        yield Diagnostic("SD207", span, message, hint)
        return
    normal, offset = _plane(tie, bricks)
    for place, anchor in zip(tie.anchors or (), _anchors(tie, bricks, normal, offset), strict=True):
        if all(norm(subtract(corner, anchor)) > OVERLAP for corner in cable.course_W):
            message = f"the tie '{name}' cannot reach its anchor at {mm(place)}, which is below its bricks"
            yield Diagnostic("SD207", source.span_of((*path, "anchors")), message, "write places beside the bricks")
            return
    names = {placed.brick.id for placed in bricks}
    others = [brick for brick in built.bricks if brick.name not in names and brick.removed is None]
    for placed in _placed([each for each in others if not isinstance(each.written.shape, RoundSolid)]):
        if crosses(placed, normal, offset, cable.course_W, OVERLAP):
            message = f"the tie '{name}' would pass through brick '{placed.brick.id}', which it does not go around"
            yield Diagnostic("SD207", span, message, f"add '{placed.brick.id}' to `around`, or move the tie")
            return


def _outside(tie: Tie, path: KeyPath, bricks: Sequence[Placed], source: Source) -> Iterator[Diagnostic]:
    for number, (placed, point) in enumerate(zip(bricks, _ends(tie, bricks), strict=True)):
        beyond = distance_outside(in_place(placed.brick.shape, placed.pose), point)
        if beyond > OVERLAP and tie.points is not None:
            message = f"this end of the tie is {mm(beyond)} outside brick '{placed.brick.id}'"
            hint = f"write x, y and z in the scene; the centre of the brick is at {_place_text(placed.pose.position_W)}"
            yield Diagnostic("SD207", source.span_of((*path, "points", number)), message, hint)
    first, last = _ends(tie, bricks)
    if first == last:
        yield Diagnostic(
            "SD207", source.span_of(path), "both ends of the tie are one place", "write different `points`"
        )


def _unjudged(built: ResolvedScenario, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report systems, bricks, actions and claims that are not judged with ties."""
    span = source.key_span_of(("ties",))
    for system in (system for system in scenario.systems if system != SYSTEM):
        message = f"ties are judged on `{SYSTEM}` only, not on the system '{system}'"
        yield Diagnostic("SD214", source.key_span_of(("systems",)), message, f"write `systems: [{SYSTEM}]`")
    if round_brick := next((each for each in built.bricks if isinstance(each.written.shape, RoundSolid)), None):
        message = f"ties are not judged beside round bricks, such as '{round_brick.name}'"
        yield Diagnostic("SD214", span, message, "use prisms, or remove `ties`")
    if scenario.supports:
        message = "ties are not judged on supports that move"
        yield Diagnostic("SD214", source.key_span_of(("supports",)), message, "remove `supports`, or `ties`")
    if scenario.samples is not None:
        message = "samples are not drawn for tied bricks"
        hint = "remove `samples` and all `uncertain` values"
        yield Diagnostic("SD214", source.key_span_of(("samples",)), message, hint)
    unknown = next((tie for tie in scenario.ties if tie.most > tie.least), None)
    weak = next((brick for brick in built.bricks if brick.written.kind.strength is not None), None)
    if unknown is not None and weak is not None:
        message = f"the strength of '{weak.name}' is not judged with ties whose tension is not known"
        yield Diagnostic("SD214", span, message, "remove the `strength` of the ties, so that they keep their `tension`")
    yield from what_moves(built, scenario, source, "SD214", NOT_MODELLED, "ties")
    yield from _claimed(scenario, source, known=unknown is None)


def _claimed(scenario: Scenario, source: Source, *, known: bool) -> Iterator[Diagnostic]:
    margins = MARGINS_OF_KNOWN if known else MARGINS
    for key, claims in (("expect", scenario.expect), ("truth", scenario.truth)):
        for number, claim in enumerate(claims):
            others = {each for each in claim.content.needed_margins if not (known and is_load(each))} - margins
            span = source.key_span_of((key, number, claim.kind))
            hint = "claim `verdict`, or the margin `load_factor` or `acceleration`"
            if others:
                what = "the load on a brick" if is_load(min(others)) else f"`{min(others)}`"
                whose = "tied bricks" if known else "ties whose tension is not known"
                yield Diagnostic("SD214", span, f"{what} is not computed for {whose}", hint)
            elif claim.content.needed_tests and not known:
                message = f"`{claim.kind}` is not judged with ties whose tension is not known"
                remedy = "remove the `strength` of the ties, so that they keep their `tension`"
                yield Diagnostic("SD214", span, message, remedy)
