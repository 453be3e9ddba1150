"""Schedules the steps of a build, and places the ground and walls."""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import cos, sin

from stability.geometry.vectors import multiply, rotate
from stability.model import GROUND, IDENTITY, Brick, Plane, Pose, Quaternion, Vec3
from stackdsl.compiler.bricks import BUILD, ActionOrder, BuiltBrick, InHand, WrittenBrick, built_bricks
from stackdsl.diagnostics import Diagnostic
from stackdsl.language.hands import ByHand
from stackdsl.language.model_base import Anchor
from stackdsl.language.schema import Scenario, Shake
from stackdsl.language.yaml.source import KeyPath, Source

# When each step begins and each brick is placed: in order, `every`, `at`, and anchors: `after: level 9 + 1 s`.


@dataclass
class Schedule:
    """The moments of all that was gone through so far."""

    bricks: list[ActionOrder] = field(default_factory=list)  # in the author's order
    impacts: list[ActionOrder] = field(default_factory=list)
    in_hands: list[InHand] = field(default_factory=list)  # when each brick comes, and is left to itself
    over: list[float] = field(default_factory=list)  # when each impact is [s]
    shaken: ActionOrder | None = None  # when the ground begins to move
    mistakes: list[Diagnostic] = field(default_factory=list)
    latest: dict[tuple[str, str], float] = field(default_factory=dict)  # of all that an anchor may name [s]

    def place(self, brick: BuiltBrick, in_hand: InHand, turn: int) -> None:
        """Let a brick be placed at a time; an anchor names when it is left to itself."""
        self.bricks.append(ActionOrder(in_hand.arrives, turn))
        self.in_hands.append(in_hand)
        events = [("level", str(brick.level)), ("brick", brick.name), *[("built", "")] * (not brick.written.inserted)]
        for event in events:
            self.latest[event] = max(self.latest.get(event, in_hand.let_go), in_hand.let_go)


def scheduled(bricks: Sequence[BuiltBrick], scenario: Scenario, source: Source) -> Schedule:
    """When everything happens: a step begins at its time, after its event, or after the step before it."""
    found = Schedule()
    last = next_start = 0.0
    turns = _turns([brick.written for brick in bricks])
    for number, step in enumerate((*scenario.build, *scenario.impacts)):
        turn = max(BUILD, number - len(scenario.build) + 1)
        path: KeyPath = ("impacts", turn - 1) if turn else ("build", number)
        start = next_start if step.at is None else step.at
        if step.after is not None:
            event = _event_time(step.after, found)
            if isinstance(event, str):
                found.mistakes.append(Diagnostic("SD205", source.span_of((*path, "after")), event, _ANCHOR_HINT))
            else:
                start = event + step.after.offset
        every = (scenario.build[number].every or 0.0) if turn == BUILD else 0.0
        hand = scenario.build[number].place if turn == BUILD else None
        first, in_hands = len(found.bricks), _in_hands(hand, start, turns[number], every)
        for brick, in_hand in zip(bricks[first : first + len(in_hands)], in_hands, strict=True):
            found.place(brick, in_hand, turn)
        if turn:
            found.impacts.append(ActionOrder(start, turn))
            found.over.append(start + scenario.impacts[turn - 1].done.lasts)
        ends = [each.let_go for each in in_hands] if turn == BUILD else found.over[-1:]
        last = max(last, start, *ends)
        next_start = last + every
    shake = scenario.world.shake
    if shake is not None:
        found.shaken = ActionOrder(_shaken_at(shake, found, source) + shake.delay, len(scenario.impacts) + 1)
    return found


def _in_hands(hand: ByHand | None, start: float, turns: Sequence[int], every: float) -> list[InHand]:
    """When the bricks of a step come, which begins at a time [s]; `turns`: which comes when, counted from 0."""
    if hand is None:
        return [InHand(time, time, time) for time in (start + index * every for index in turns)]
    comes, lasts = hand.course.duration, hand.lasts
    begins = [start]
    for _ in range(max(turns, default=0)):  # from when a brick is let go, to the very same digit
        begins.append((begins[-1] + lasts) + every)
    return [InHand(begins[index], begins[index] + comes, begins[index] + lasts) for index in turns]


def _shaken_at(shake: Shake, found: Schedule, source: Source) -> float:
    """When the ground is to shake [s]: after the build, unless it is said."""
    if shake.at is not None:
        return shake.at
    anchor = shake.after or Anchor("built")
    event = _event_time(anchor, found)
    if isinstance(event, str):
        span = source.span_of(("world", "shake", "after"))
        found.mistakes.append(
            Diagnostic("SD205", span, event.replace("this step waits", "the ground waits"), SHAKEN_HINT)
        )
        return 0.0
    return event + anchor.offset


def _turns(written: Sequence[WrittenBrick]) -> Mapping[int, list[int]]:
    """By step, the turn of each of its bricks among what is set down one after another."""
    found: dict[int, list[int]] = defaultdict(list)
    for brick in written:
        turns = found[brick.step]
        turns.append((turns[-1] + (not brick.together)) if turns else 0)
    return found


SHAKEN_HINT = "wait for something that the build or an impact does"
_ANCHOR_HINT = "only what earlier steps do can be waited for"


def _event_time(anchor: Anchor, found: Schedule) -> float | str:
    """When an event of the steps so far is over [s], or why it never happens."""
    if anchor.event == "start":
        return 0.0
    if anchor.event == "impact":
        number = int(anchor.name)
        if number <= len(found.impacts):
            return found.over[number - 1]
        return f"this step waits for impact {number}, and there are {len(found.impacts)} before it"
    if (time := found.latest.get((anchor.event, anchor.name))) is not None:
        return time
    what = {"built": "anything", "level": f"level {anchor.name}", "brick": f"brick '{anchor.name}'"}[anchor.event]
    return f"this step waits for {what}, and no earlier step builds it"


# Ground, walls and tilt: the fixed bodies, and the turn from the frame of the scene to W.


Z_AXIS: Vec3 = (0.0, 0.0, 1.0)


def planes_of(scenario: Scenario) -> Iterator[Plane]:
    """Ground and walls in the frame of the scene."""
    ground = scenario.world.ground.friction
    yield Plane(GROUND, (0.0, 0.0, 0.0), Z_AXIS, scenario.friction if ground is None else ground)
    for number, wall in enumerate(scenario.world.walls, start=1):
        x, y = cos(wall.bearing), sin(wall.bearing)
        friction = scenario.friction if wall.friction is None else wall.friction
        yield Plane(f"wall{number}", (x * wall.distance, y * wall.distance, 0.0), (-x, -y, 0.0), friction)


def tilt_of(scenario: Scenario) -> Quaternion:
    """From the frame of the scene to W: the ground's normal leans towards downhill."""
    angle, towards = scenario.world.tilt.angle, scenario.world.tilt.towards
    if angle == 0.0:
        return IDENTITY
    half = angle / 2.0
    return (-sin(towards) * sin(half), cos(towards) * sin(half), 0.0, cos(half))


def turned_plane(plane: Plane, tilt: Quaternion) -> Plane:
    """A plane of the scene in W."""
    if tilt == IDENTITY:
        return plane
    return replace(plane, point_W=rotate(tilt, plane.point_W), normal_W=rotate(tilt, plane.normal_W))


def turned_pose(pose: Pose, tilt: Quaternion) -> Pose:
    """A pose of the scene in W; to the bit the same if there is no tilt."""
    if tilt == IDENTITY:
        return pose
    return Pose(rotate(tilt, pose.position_W), multiply(tilt, pose.orientation))


# All that a scenario builds, throws and does, and when: what its checks look at, and what its timeline is made of.


@dataclass(frozen=True, slots=True)
class Built:
    """A scenario with every name and every time resolved, in the frame of the scene."""

    bricks: Sequence[BuiltBrick]  # in the author's order
    missiles: Mapping[int, Brick]  # what is thrown or dropped, by the number of the impact
    impacts: Sequence[ActionOrder]  # when each begins
    shaken: ActionOrder | None  # when the ground begins to move, if it does
    planes: Sequence[Plane]
    mistimed: Sequence[Diagnostic]  # what has no time; then the times are wrong, and nothing fits

    @property
    def in_order(self) -> list[BuiltBrick]:
        """The bricks by when they are placed, then in the author's order."""
        return sorted(self.bricks, key=lambda brick: brick.placed)

    @property
    def levels(self) -> int:
        """The highest level."""
        return max((brick.level for brick in self.bricks), default=0)


def built_of(scenario: Scenario, source: Source) -> Built:
    """What is built and done, as far as it can be said."""
    planes = tuple(planes_of(scenario))
    bricks = built_bricks(scenario, planes)
    schedule = scheduled(bricks, scenario, source)
    return Built(
        bricks=[_timed(brick, number, schedule) for number, brick in enumerate(bricks)],
        missiles=missiles_of(scenario),
        impacts=schedule.impacts,
        shaken=schedule.shaken,
        planes=planes,
        mistimed=schedule.mistakes,
    )


def missiles_of(scenario: Scenario) -> dict[int, Brick]:
    """The bricks that are thrown or dropped, by the number of the impact; `thrown-1` if the first has no name."""
    found = {}
    for number, impact in enumerate(scenario.impacts):
        missile = impact.done.missile
        if missile is not None:
            kind = missile.brick or scenario.brick
            name = missile.name or f"{missile.how}-{number + 1}"
            found[number] = Brick(name, kind.form.shape, kind.mass_of(kind.form))
    return found


def _timed(brick: BuiltBrick, number: int, schedule: Schedule) -> BuiltBrick:
    gone = None if brick.removed_in is None else schedule.impacts[brick.removed_in]
    return replace(brick, placed=schedule.bricks[number], gone=gone, in_hand=schedule.in_hands[number])
