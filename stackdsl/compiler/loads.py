"""Loads of a scenario: their bricks by name, their forces in W, and refusals of what is not computed under loads."""

from collections.abc import Iterator, Sequence
from itertools import accumulate, pairwise, zip_longest
from math import cos, sin
from typing import Final

from stability.contacts.detection import contacts_between, contacts_with_plane, solid
from stability.geometry.compound import Compound
from stability.geometry.placed_shape import bounds_W, distance_outside, in_place, top_W
from stability.geometry.polygons import cut
from stability.geometry.round_solid import RoundSolid
from stability.geometry.spatial_grid import Neighbours
from stability.geometry.vectors import add, add_scaled, cross, dot, inverse, norm, rotate, scale, subtract
from stability.loads import Load as AppliedLoad
from stability.loads import LoadCourse, Loads
from stability.model import BodyId, Brick, ConvexShape, Face, Quaternion, Vec3
from stability.problem import Placed, Tolerances
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
from stackdsl.trace import USED_STRENGTH, is_load
from stackdsl.wording import mm

MAX_LOADED: Final = 100_000  # loaded bricks, each counted once per load; some seconds
SYSTEM: Final = "exact"  # the only system that judges loads
MARGINS: Final = frozenset({"load_factor", "acceleration", "friction", "settlement", USED_STRENGTH})
HANDS: Final = frozenset({"move", "hold"})
FACING: Final = cos(0.7)  # about 40 deg: the most by which a face may be turned from the direction that names it
EDGE_ON: Final = 1e-9  # cosine below which a face is seen edge on
FLUSH: Final = 1e-6  # of the cosine of the angle between a face and a contact on it
COVERED: Final = 1e-12  # [m2] of a face that is covered but for rounding
REACH: Final = 1e-3  # [m] beyond which no gap counts as contact
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
    if load.all:
        return [brick for brick in built.bricks if brick.removed is None]
    if load.level is not None:
        return [brick for brick in built.bricks if brick.level == load.level and brick.removed is None]
    names = set((load.brick,) if load.bricks is None else load.bricks)
    return [brick for brick in built.bricks if brick.name in names]


def applied(load: Load, built: ResolvedScenario, scenario: Scenario) -> Iterator[AppliedLoad]:
    """Yield the parts of a load of the amount 1 on each of its bricks."""
    bricks, tilt = loaded_bricks(load, built), tilt_of(scenario)
    unit = scenario.world.gravity if load.is_mass else 1.0  # the weight of a mass along gravity also in a tilted scene
    surface = _top(bricks) if load.surface is None else load.surface
    exposed = _ExposedFaces(built, bricks) if load.wind is not None else None
    for brick in bricks:
        if exposed is not None and load.towards is not None:
            direction = direction_of(load.towards)
            for middle, area in exposed.faces(brick, direction):
                yield AppliedLoad(brick.name, _turned(scale(area, direction), tilt), middle)
        elif load.pressure is not None or load.fluid is not None:
            face = _known_face(load, brick)
            middle, total = _pressed(brick.written.shape, face)
            if load.fluid is not None:
                middle, total = _submerged(brick, face, surface)
            if total:
                yield AppliedLoad(brick.name, scale(-unit * total, face.normal), middle, turns=True)
        else:
            share = unit * (brick.written.mass if load.acceleration is not None else 1.0 / len(bricks))
            yield _at_a_point(load, brick, share, tilt)


def _at_a_point(load: Load, brick: ResolvedBrick, share: float, tilt: Quaternion) -> AppliedLoad:
    """Return a force or a moment of a size, where it acts on a brick."""
    pose = brick.written.pose
    force, moment, point = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), load.point or (0.0, 0.0, 0.0)
    if load.weight is not None:
        force = scale(share, DOWN)
    elif load.moment is not None and load.about is not None:
        moment = _turned(scale(share, direction_of(load.about)), tilt)
    elif load.line is not None and load.towards is not None and load.from_ is not None and load.to is not None:
        # On a rigid brick, a uniform line load acts as its resultant.
        length = norm(subtract(load.to, load.from_))
        force = _turned(scale(share * length, direction_of(load.towards)), tilt)
        point = scale(0.5, add(load.from_, load.to))
    elif load.towards is not None:
        force = _turned(scale(share, direction_of(load.towards)), tilt)
    point_B = rotate(inverse(pose.orientation), point)
    if load.face is not None:
        point_B, _ = _pressed(brick.written.shape, _known_face(load, brick))
    return AppliedLoad(brick.name, force, point_B, moment)


def _known_face(load: Load, brick: ResolvedBrick) -> Face:
    assert load.face is not None
    face = face_of(brick, load.face)
    assert isinstance(face, Face)  # others are reported by `invalid_loads`
    return face


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


def _pressed(shape: ConvexShape, face: Face) -> tuple[Vec3, float]:
    """Return the centroid of a face [m], in axes of the brick, and its area [m2]."""
    if isinstance(shape, RoundSolid):
        return shape.end(face)
    corners = [shape.corners[corner] for corner in face.corners]
    return _integrated(corners, [1.0] * len(corners))


def _submerged(brick: ResolvedBrick, face: Face, surface: float) -> tuple[Vec3, float]:
    """Return the centre of a pressure that grows with the depth [m], in axes of the brick, and its integral [m3]."""
    pose, shape = brick.written.pose, brick.written.shape
    corners = [shape.corners[corner] for corner in face.corners]
    depths = [surface - add(pose.position_W, rotate(pose.orientation, corner))[2] for corner in corners]
    wet = cut([(*corner, depth) for corner, depth in zip(corners, depths, strict=True)], depths)
    return _integrated([corner[:3] for corner in wet], [corner[3] for corner in wet])


def _integrated(corners: Sequence[Vec3], pressures: Sequence[float]) -> tuple[Vec3, float]:
    """Return centre and integral of a pressure on a flat convex polygon, linear between its values at the corners."""
    total, moment = 0.0, (0.0, 0.0, 0.0)
    for second, third in pairwise(range(1, len(corners))):
        triangle, values = [(corners[i]) for i in (0, second, third)], [pressures[i] for i in (0, second, third)]
        first = triangle[0]
        area = 0.5 * norm(cross(subtract(triangle[1], first), subtract(triangle[2], first)))
        total += area * sum(values) / 3.0
        for corner, value in zip(triangle, values, strict=True):
            moment = add_scaled(moment, area * (sum(values) + value) / 12.0, corner)
    return (scale(1.0 / total, moment), total) if total else ((0.0, 0.0, 0.0), 0.0)


def _top(bricks: Sequence[ResolvedBrick]) -> float:
    return max((top_W(brick.written.shape, brick.written.pose) for brick in bricks), default=0.0)


class _ExposedFaces:
    """The parts of faces that no other body covers."""

    def __init__(self, built: ResolvedScenario, bricks: Sequence[ResolvedBrick]) -> None:
        staying = [brick for brick in built.bricks if brick.removed is None] + list(bricks)
        self._solids = {
            brick.name: solid(Placed(Brick(brick.name, brick.written.shape, brick.written.mass), brick.written.pose))
            for brick in staying
        }
        self._planes = built.planes
        self._near = Neighbours[BodyId]()
        for brick in {brick.name: brick for brick in staying}.values():
            self._near.add(brick.name, *bounds_W(brick.written.shape, brick.written.pose))

    def faces(self, brick: ResolvedBrick, direction: Vec3) -> Iterator[tuple[Vec3, float]]:
        """Yield centre [m], in axes of the brick, and area across a direction [m2] of what is seen of each face."""
        pose, shape = brick.written.pose, brick.written.shape
        patches = list(self._patches(brick.name))
        for face in shape.faces:
            normal_W = rotate(pose.orientation, face.normal)
            seen = -dot(normal_W, direction)
            if seen <= EDGE_ON:
                continue
            middle, area = _pressed(shape, face)
            moment = scale(area, middle)
            for normal_out, corners_W in patches:
                if dot(normal_out, normal_W) < 1.0 - FLUSH:
                    continue
                corners = [rotate(inverse(pose.orientation), subtract(each, pose.position_W)) for each in corners_W]
                covered, part = _integrated(corners, [1.0] * len(corners))
                area, moment = area - part, add_scaled(moment, -part, covered)
            if area > COVERED:
                yield scale(1.0 / area, moment), seen * area

    def _patches(self, name: BodyId) -> Iterator[tuple[Vec3, Sequence[Vec3]]]:
        """Yield the contact areas of a brick, with their normals from the brick outwards."""
        one = self._solids[name]
        contacts = [each for plane in self._planes for each in contacts_with_plane(one, plane, Tolerances())]
        for other in self._near.neighbours(name, REACH):
            contacts += contacts_between(one, self._solids[other], 0.0, Tolerances())
        for contact in contacts:
            if len(contact.normals_W) == 1:
                (normal,) = contact.normals_W
                yield scale(1.0 if contact.lower == name else -1.0, normal), contact.points_W


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
            yield from _dry(load, path, built, source)
            yield from _early(load, number, path, built, source)
    loaded = [len(loaded_bricks(load, built)) for load in scenario.loads]
    if sum(loaded) > MAX_LOADED:
        number = next(number for number, total in enumerate(accumulate(loaded)) if total > MAX_LOADED)
        message = f"all loads together act on {sum(loaded)} bricks; the maximum is {MAX_LOADED}"
        yield Diagnostic("SD206", source.span_of(("loads", number)), message, "load fewer bricks")
    if scenario.loads:
        yield from _unjudged(built, scenario, source)


def _misplaced(load: Load, path: KeyPath, built: ResolvedScenario, source: Source) -> Iterator[Diagnostic]:
    """Report faces that no brick has, fluids that reach no face, and points outside of bricks."""
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


def _dry(load: Load, path: KeyPath, built: ResolvedScenario, source: Source) -> Iterator[Diagnostic]:
    """Report a fluid whose surface is below all loaded faces."""
    bricks = loaded_bricks(load, built)
    lowest = min((bounds_W(brick.written.shape, brick.written.pose)[0][2] for brick in bricks), default=0.0)
    if load.surface is not None and load.surface <= lowest:
        message = f"the surface of the fluid is not above the loaded bricks, which begin at {mm(lowest)}"
        hint = "write the height of the surface above the ground"
        yield Diagnostic("SD207", source.span_of((*path, "surface")), message, hint)


def _early(load: Load, number: int, path: KeyPath, built: ResolvedScenario, source: Source) -> Iterator[Diagnostic]:
    """Report bricks that are pulled out before their load begins, or fall into place."""
    if built.timing_mistakes:
        return
    key = next(key for key in ("brick", "bricks", "level", "all") if getattr(load, key) is not None)
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
    yield from _of_other_shapes(built, scenario, source)
    yield from _handled(scenario, source)
    yield from _claimed(built, scenario, source)


def _of_other_shapes(built: ResolvedScenario, scenario: Scenario, source: Source) -> Iterator[Diagnostic]:
    """Report wind and fluids on bricks whose faces are round, or hidden inside."""
    for number, load in enumerate(scenario.loads):
        if load.wind is not None and any(
            isinstance(each.written.shape, Compound | RoundSolid) for each in built.bricks
        ):
            message = "`wind` is not computed beside round bricks and bricks of several parts"
        elif load.fluid is not None and any(
            isinstance(each.written.shape, RoundSolid) for each in loaded_bricks(load, built)
        ):
            message = "`fluid` is not computed on round bricks"
        else:
            continue
        span = source.key_span_of(("loads", number, load.kind))
        yield Diagnostic("SD211", span, message, "write `pressure` on the faces that it meets")


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
