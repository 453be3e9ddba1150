"""Loads of a scenario: their bricks by name, their forces in W, and refusals of what is not computed under loads."""

from collections.abc import Iterator, Sequence
from itertools import pairwise, zip_longest
from math import cos, sin
from typing import Final

from stability.geometry.placed_shape import distance_outside, in_place
from stability.geometry.round_solid import RoundSolid
from stability.geometry.vectors import add, add_scaled, cross, dot, inverse, norm, rotate, scale, subtract
from stability.loads import Load as AppliedLoad
from stability.loads import LoadCourse, Loads
from stability.model import ConvexShape, Face, Quaternion, Vec3
from stackdsl.compiler.bricks import ActionOrder, ResolvedBrick
from stackdsl.compiler.fit import OVERLAP
from stackdsl.compiler.joints import are_joined
from stackdsl.compiler.schedule import ResolvedScenario, tilt_of
from stackdsl.diagnostics import Diagnostic, did_you_mean
from stackdsl.language.claims.claim import Claim
from stackdsl.language.loads import DOWN, FACES, WORDS, Direction, Load
from stackdsl.language.schema import Scenario
from stackdsl.language.value_types import named_in
from stackdsl.language.yaml.source import KeyPath, Source
from stackdsl.timeline import LoadsAction
from stackdsl.trace import is_load
from stackdsl.wording import mm

SYSTEM: Final = "exact"  # the only system that judges loads
MARGINS: Final = frozenset({"load_factor", "acceleration", "friction"})
HANDS: Final = frozenset({"move", "hold"})
FACING: Final = cos(0.7)  # about 40 deg: the most by which a face may be turned from the direction that names it
AS_WELL: Final = 1e-6  # difference of two cosines below which two faces are named equally well


def loads_in_time(built: ResolvedScenario, scenario: Scenario) -> Iterator[tuple[ActionOrder, LoadsAction]]:
    """Yield the changes of loads in order of time."""
    courses = [
        (
            begins.time,
            [(begins.time + time, amount) for time, amount in load.rows],
            list(applied(load, built, scenario)),
        )
        for load, begins in zip(scenario.loads, built.loaded, strict=True)
    ]
    # The timeline is the same whatever the order of the file.
    courses.sort(key=lambda course: repr(course[2]))
    placed = {brick.name: brick.placed.time for brick in built.bricks}
    times = sorted({time for begins, rows, _ in courses for time in (begins, *(row[0] for row in rows))})
    for time, next_time in zip_longest(times, times[1:]):
        acting = [(rows, units) for begins, rows, units in courses if begins <= time]
        first = Loads(tuple(unit.times(_amount(rows, time)) for rows, units in acting for unit in units))
        last = first
        if next_time is not None:
            until = next_time
            last = Loads(
                tuple(unit.times(_amount(rows, until, before=True)) for rows, units in acting for unit in units)
            )
        begun = {unit.brick for begins, _, units in courses if begins == time for unit in units}
        bricks = tuple(sorted(brick for brick in begun if placed[brick] <= time))
        course = LoadCourse(first, last, time, time if next_time is None else next_time)
        yield ActionOrder(time, len(scenario.impacts) + 2), LoadsAction(time, course, bricks)


def _amount(rows: Sequence[tuple[float, float]], time: float, *, before: bool = False) -> float:
    """Return the amount of a table at a time, or just before it; two rows with one time are a jump."""
    past = [row for row in rows if (row[0] < time if before else row[0] <= time)]
    if not past:
        return rows[0][1] if rows[0][0] == time else 0.0
    (start, amount), later = past[-1], rows[len(past) :]
    if not later:
        return amount
    end, target = later[0]
    return amount + (target - amount) * (time - start) / (end - start)


def loaded_bricks(load: Load, built: ResolvedScenario) -> list[ResolvedBrick]:
    """Return the bricks on which a load acts."""
    if load.level is not None:
        return [brick for brick in built.bricks if brick.level == load.level and brick.removed is None]
    names = set((load.brick,) if load.bricks is None else load.bricks)
    return [brick for brick in built.bricks if brick.name in names]


def applied(load: Load, built: ResolvedScenario, scenario: Scenario) -> Iterator[AppliedLoad]:
    """Yield the parts of a load of the amount 1 on each of its bricks."""
    bricks, tilt = loaded_bricks(load, built), tilt_of(scenario)
    share = 1.0 / len(bricks) if bricks else 0.0
    for brick in bricks:
        pose, shape = brick.written.pose, brick.written.shape
        if load.pressure is not None:
            assert load.face is not None
            face = face_of(brick, load.face)
            assert isinstance(face, Face)  # others are reported by `invalid_loads`
            middle, area = _middle_and_area(shape, face)
            yield AppliedLoad(brick.name, scale(-area, face.normal), middle, turns=True)
            continue
        force, moment, point = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), load.point or (0.0, 0.0, 0.0)
        point_B = rotate(inverse(pose.orientation), point)
        if load.weight is not None:
            force = scale(
                share * (scenario.world.gravity if load.is_mass else 1.0), DOWN
            )  # along gravity also in a tilted scene
        elif load.force is not None and load.towards is not None:
            force = _turned(scale(share, direction_of(load.towards)), tilt)
        elif load.moment is not None and load.about is not None:
            moment = _turned(scale(share, direction_of(load.about)), tilt)
        elif load.line is not None and load.towards is not None and load.from_ is not None and load.to is not None:
            # On a rigid brick, a uniform line load acts as its resultant.
            length = norm(subtract(load.to, load.from_))
            force = _turned(scale(length, direction_of(load.towards)), tilt)
            point_B = rotate(inverse(pose.orientation), scale(0.5, add(load.from_, load.to)))
        if load.face is not None:
            face = face_of(brick, load.face)
            assert isinstance(face, Face)
            point_B, _ = _middle_and_area(shape, face)
        yield AppliedLoad(brick.name, force, point_B, moment)


def _turned(vector: Vec3, tilt: Quaternion) -> Vec3:
    return rotate(tilt, vector)


def direction_of(direction: Direction) -> Vec3:
    """Return the unit vector of a word or a bearing, in the scene frame."""
    if isinstance(direction, str):
        return (WORDS | FACES)[direction]
    # Rounded to digits on which all processors agree.
    return (round(cos(direction), 15), round(sin(direction), 15), 0.0)


def face_of(brick: ResolvedBrick, named: Direction) -> Face | str:
    """Return the face of a brick that looks into a direction, or why none does."""
    towards_B = rotate(inverse(brick.written.pose.orientation), direction_of(named))
    shape = brick.written.shape
    faces = shape.flat_faces if isinstance(shape, RoundSolid) else shape.faces
    cosines = sorted(((dot(face.normal, towards_B), face) for face in faces), key=lambda each: -each[0])
    if len(cosines) < 2:  # noqa: PLR2004 -- a solid has one face at least on each side
        return "no face looks that way" if not cosines or cosines[0][0] < FACING else cosines[0][1]
    (best, face), (second, _) = cosines[:2]
    if best < FACING:
        return "no face looks that way"
    return "two faces look that way equally" if second > best - AS_WELL else face


def _middle_and_area(shape: ConvexShape, face: Face) -> tuple[Vec3, float]:
    """Return the centroid of a face [m], in axes of the brick, and its area [m2]."""
    if isinstance(shape, RoundSolid):
        return shape.end(face)
    first, *others = (shape.corners[corner] for corner in face.corners)
    total, middle = 0.0, (0.0, 0.0, 0.0)
    for one, other in pairwise(others):
        area = 0.5 * dot(face.normal, cross(subtract(one, first), subtract(other, first)))
        total += area
        middle = add_scaled(middle, area / 3.0, add(first, add(one, other)))
    return scale(1.0 / total, middle), total


# Mistakes.


def invalid_loads(built: ResolvedScenario, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report loads on unknown bricks, faces and points, and what is not computed under loads."""
    names = [brick.name for brick in built.bricks]
    known = set(names)
    for number, load in enumerate(scenario.loads):
        path: KeyPath = ("loads", number)
        unknown = [reference for reference in named_in(load, path) if reference.name not in known]
        for reference in unknown:
            hint = did_you_mean(reference.name, names) or f"the names of the bricks are {names[0]} to {names[-1]}"
            yield Diagnostic("SD204", source.span_of(reference.path), f"there is no brick '{reference.name}'", hint)
        if load.level is not None and not loaded_bricks(load, built):
            message = f"there is no level {load.level} with bricks that stay"
            span = source.span_of((*path, "level"))
            yield Diagnostic("SD204", span, message, f"write a level from 1 to {built.levels}")
        if not unknown:
            yield from _misplaced(load, path, built, source)
            yield from _early(load, number, path, built, source)
    if scenario.loads:
        yield from _unjudged(built, scenario, source)


def _misplaced(load: Load, path: KeyPath, built: ResolvedScenario, source: Source) -> Iterator[Diagnostic]:
    """Report faces that no brick has, and points outside of bricks."""
    for brick in loaded_bricks(load, built):
        if load.face is not None and isinstance(wrong := face_of(brick, load.face), str):
            hint = "write the outward direction of one face: top, bottom, or a horizontal bearing such as 90 deg"
            message = f"the face of brick '{brick.name}' is unknown: {wrong}"
            yield Diagnostic("SD207", source.span_of((*path, "face")), message, hint)
            return
        shape = in_place(brick.written.shape, brick.written.pose)
        for key, point in (("point", load.point), ("from", load.from_), ("to", load.to)):
            if point is None:
                continue
            beyond = distance_outside(shape, add(brick.written.pose.position_W, point))
            if beyond > OVERLAP:
                hint = "write the point relative to the centre of the brick, along the axes of the scene"
                message = f"the point is {mm(beyond)} outside brick '{brick.name}'"
                yield Diagnostic("SD207", source.span_of((*path, key)), message, hint)


def _early(load: Load, number: int, path: KeyPath, built: ResolvedScenario, source: Source) -> Iterator[Diagnostic]:
    """Report bricks that are pulled out before their load begins, or fall into place."""
    if built.timing_mistakes:
        return
    key = next(key for key in ("brick", "bricks", "level") if getattr(load, key) is not None)
    for brick in loaded_bricks(load, built):
        if brick.removed is not None and brick.removed <= built.loaded[number]:
            message = f"brick '{brick.name}' is pulled out before this load begins"
            yield Diagnostic("SD204", source.span_of((*path, key)), message, "begin earlier, or load another brick")


def _is_static(claim: Claim) -> bool:
    return claim.content.needs_statics


def _unjudged(built: ResolvedScenario, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report systems, actions and margins that loaded bricks do not have."""
    for system in (system for system in scenario.systems if system != SYSTEM):
        message = f"loads are judged on `{SYSTEM}` only, not on the system '{system}'"
        yield Diagnostic("SD211", source.key_span_of(("systems",)), message, f"write `systems: [{SYSTEM}]`")
    if scenario.samples is not None:
        message = "samples are not drawn for bricks under loads"
        yield Diagnostic(
            "SD211", source.key_span_of(("samples",)), message, "remove `samples` and all `uncertain` values"
        )
    yield from _handled(scenario, source)
    yield from _claimed(built, scenario, source)


def _handled(scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    for number, step in enumerate(scenario.build):
        if step.place is not None:
            message = "hands are not played for bricks under loads"
            yield Diagnostic("SD211", source.key_span_of(("build", number, "place")), message, "remove `place`")
    for number, impact in enumerate(scenario.impacts):
        if impact.kind in HANDS:
            span = source.key_span_of(("impacts", number, impact.kind))
            yield Diagnostic("SD211", span, "hands are not played for bricks under loads", f"remove `{impact.kind}`")


def _claimed(built: ResolvedScenario, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    if are_joined(built, scenario) and not (scenario.expect and all(map(_is_static, scenario.expect))):
        message = "joined bricks are not played under loads, only judged at rest"
        hint = "expect only `verdict` and `margin`"
        yield Diagnostic("SD211", source.key_span_of(("loads",)), message, hint)
    for key, claims in (("expect", scenario.expect), ("truth", scenario.truth)):
        for number, claim in enumerate(claims):
            others = sorted(margin for margin in {*claim.content.needed_margins} - MARGINS if not is_load(margin))
            if others:
                message = f"the margin `{others[0]}` is not computed for bricks under loads"
                span = source.key_span_of((key, number, claim.kind))
                yield Diagnostic("SD211", span, message, "claim the margin `load_factor`, `acceleration` or `friction`")
