"""Schedules all steps and impacts, and places the ground and walls."""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import cos, sin

from stability.geometry.vectors import multiply, rotate
from stability.model import GROUND, IDENTITY, Brick, Plane, Pose, Quaternion, Vec3
from stackdsl.compiler.bricks import BUILD, ActionOrder, HandTimes, ResolvedBrick, WrittenBrick, resolved_bricks
from stackdsl.diagnostics import Diagnostic, did_you_mean
from stackdsl.language.hands import ByHand
from stackdsl.language.model_base import Anchor, Timed
from stackdsl.language.quantities import InputError
from stackdsl.language.schema import Scenario
from stackdsl.language.yaml.source import KeyPath, Source

# Times: from the order of steps, `every`, `at`, and anchors such as `after: level 9 + 1 s`.


@dataclass
class Schedule:
    """The times of the steps and impacts scheduled so far."""

    bricks: list[ActionOrder] = field(default_factory=list)  # in file order
    impacts: list[ActionOrder] = field(default_factory=list)
    in_hands: list[HandTimes] = field(default_factory=list)  # of each brick
    over: list[float] = field(default_factory=list)  # end of each impact [s]
    shaken: ActionOrder | None = None  # start of the ground motion
    loaded: list[ActionOrder] = field(default_factory=list)  # start of each load
    mistakes: list[Diagnostic] = field(default_factory=list)
    latest: dict[tuple[str, str], float] = field(default_factory=dict)  # time of each event that an anchor may name [s]

    def place(self, brick: ResolvedBrick, in_hand: HandTimes, turn: int) -> None:
        """Schedule a brick; anchors refer to the time of its release."""
        self.bricks.append(ActionOrder(in_hand.arrives, turn))
        self.in_hands.append(in_hand)
        events = [("level", str(brick.level)), ("brick", brick.name), *[("built", "")] * (not brick.written.inserted)]
        for event in events:
            self.latest[event] = max(self.latest.get(event, in_hand.let_go), in_hand.let_go)


def scheduled(bricks: Sequence[ResolvedBrick], scenario: Scenario, source: Source) -> Schedule:
    """Schedule everything: a step begins at its time, after its event, or after the previous step."""
    schedule = Schedule()
    last = next_start = 0.0
    turns = _turns([brick.written for brick in bricks])
    for number, step in enumerate((*scenario.build, *scenario.impacts)):
        turn = max(BUILD, number - len(scenario.build) + 1)
        path: KeyPath = ("impacts", turn - 1) if turn else ("build", number)
        start = next_start if step.at is None else step.at
        if step.after is not None:
            event = _event_time(step.after, schedule)
            if isinstance(event, InputError):
                span = source.span_of((*path, "after"))
                schedule.mistakes.append(Diagnostic(event.code, span, event.message, event.hint))
            else:
                start = event + step.after.offset
        every = (scenario.build[number].every or 0.0) if turn == BUILD else 0.0
        hand = scenario.build[number].place if turn == BUILD else None
        first, in_hands = len(schedule.bricks), _hand_times(hand, start, turns[number], every)
        for brick, in_hand in zip(bricks[first : first + len(in_hands)], in_hands, strict=True):
            schedule.place(brick, in_hand, turn)
        if turn:
            schedule.impacts.append(ActionOrder(start, turn))
            schedule.over.append(start + scenario.impacts[turn - 1].content.lasts)
        ends = [in_hand.let_go for in_hand in in_hands] if turn == BUILD else schedule.over[-1:]
        last = max(last, start, *ends)
        next_start = last + every
    shake = scenario.world.shake
    if shake is not None:
        begins = _begins(shake, ("world", "shake"), "the ground waits", schedule, source)
        schedule.shaken = ActionOrder(begins + shake.delay, len(scenario.impacts) + 1)
    for number, load in enumerate(scenario.loads):
        begins = _begins(load, ("loads", number), "this load waits", schedule, source)
        schedule.loaded.append(ActionOrder(begins, len(scenario.impacts) + 2))
    return schedule


def _hand_times(hand: ByHand | None, start: float, turns: Sequence[int], every: float) -> list[HandTimes]:
    """Return the times of the bricks of a step that starts at `start` [s]; `turns` are their places in sequence."""
    if hand is None:
        return [HandTimes(time, time, time) for time in (start + index * every for index in turns)]
    comes, lasts = hand.course.duration, hand.lasts
    begins = [start]
    for _ in range(max(turns, default=0)):  # summed like the releases, for bitwise equal times
        begins.append((begins[-1] + lasts) + every)
    return [HandTimes(begins[index], begins[index] + comes, begins[index] + lasts) for index in turns]


def _begins(begun: Timed, path: KeyPath, waits: str, schedule: Schedule, source: Source) -> float:
    """Return the start of what is no step, such as shaking [s]; by default after the build."""
    if begun.at is not None:
        return begun.at
    anchor = begun.after or Anchor("built")
    event = _event_time(anchor, schedule)
    if isinstance(event, InputError):
        span = source.span_of((*path, "after"))
        message = event.message.replace("this step waits", waits).replace("earlier step", "step")
        schedule.mistakes.append(Diagnostic(event.code, span, message, event.hint))
        return 0.0
    return event + anchor.offset


def _turns(written: Sequence[WrittenBrick]) -> Mapping[int, list[int]]:
    """Return for each step the place of each brick in the sequence; bricks set down together share one."""
    by_step: dict[int, list[int]] = defaultdict(list)
    for brick in written:
        turns = by_step[brick.step]
        turns.append((turns[-1] + (not brick.together)) if turns else 0)
    return by_step


def _event_time(anchor: Anchor, schedule: Schedule) -> float | InputError:
    """Return the end of an event of the steps so far [s], or the mistake if there is no such event."""
    if anchor.event == "start":
        return 0.0
    if anchor.event == "impact":
        number, count = int(anchor.name), len(schedule.impacts)
        if number <= count:
            return schedule.over[number - 1]
        precede = f"only {count} impact{'s precede' if count > 1 else ' precedes'}" if count else "no impact precedes"
        message = f"this step waits for impact {number}, but {precede} it"
        return InputError("SD205", message, _up_to("impact", count))
    if (time := schedule.latest.get((anchor.event, anchor.name))) is not None:
        return time
    event = {"built": "anything", "level": f"level {anchor.name}", "brick": f"brick '{anchor.name}'"}[anchor.event]
    names = [name for kind, name in schedule.latest if kind == anchor.event]
    if anchor.event == "level":
        hint = _up_to("level", max(map(int, names), default=0))
    else:
        hint = did_you_mean(anchor.name, names) or "name another event"
    return InputError("SD205", f"this step waits for {event}, but no earlier step builds it", hint)


def _up_to(noun: str, highest: int) -> str:
    """Return the remedy for a number of a level or an impact that is too high."""
    if not highest:
        return "remove `after`, or name another event"
    return f"write {noun} {f'1 to {noun} {highest}' if highest > 1 else '1'}"


# Ground, walls, and the tilt, which is the rotation from the scene frame to W.


Z_AXIS: Vec3 = (0.0, 0.0, 1.0)


def planes_of(scenario: Scenario) -> Iterator[Plane]:
    """Yield the ground and the walls, in the scene frame."""
    ground = scenario.world.ground.friction
    yield Plane(GROUND, (0.0, 0.0, 0.0), Z_AXIS, scenario.friction if ground is None else ground)
    for number, wall in enumerate(scenario.world.walls, start=1):
        x, y = cos(wall.bearing), sin(wall.bearing)
        friction = scenario.friction if wall.friction is None else wall.friction
        yield Plane(f"wall{number}", (x * wall.distance, y * wall.distance, 0.0), (-x, -y, 0.0), friction)


def tilt_of(scenario: Scenario) -> Quaternion:
    """Return the rotation from the scene frame to W, which leans the ground's normal downhill."""
    angle, towards = scenario.world.tilt.angle, scenario.world.tilt.towards
    if angle == 0.0:
        return IDENTITY
    half = angle / 2.0
    return (-sin(towards) * sin(half), cos(towards) * sin(half), 0.0, cos(half))


def turned_plane(plane: Plane, tilt: Quaternion) -> Plane:
    """Return a plane of the scene in W."""
    if tilt == IDENTITY:
        return plane
    return replace(plane, point_W=rotate(tilt, plane.point_W), normal_W=rotate(tilt, plane.normal_W))


def turned_pose(pose: Pose, tilt: Quaternion) -> Pose:
    """Return a pose of the scene in W; bitwise equal without a tilt."""
    if tilt == IDENTITY:
        return pose
    return Pose(rotate(tilt, pose.position_W), multiply(tilt, pose.orientation))


# The resolved scenario, from which checks and the timeline are made.


@dataclass(frozen=True, slots=True)
class ResolvedScenario:
    """A scenario with all names and times resolved, in the scene frame."""

    bricks: Sequence[ResolvedBrick]  # in file order
    missiles: Mapping[int, Brick]  # thrown and dropped bricks, by the index of the impact
    impacts: Sequence[ActionOrder]  # start of each
    shaken: ActionOrder | None  # start of the ground motion
    loaded: Sequence[ActionOrder]  # start of each load
    planes: Sequence[Plane]
    timing_mistakes: Sequence[Diagnostic]  # about unknown events; if any, the times are invalid

    @property
    def in_order(self) -> list[ResolvedBrick]:
        """The bricks in order of their placement, then in file order."""
        return sorted(self.bricks, key=lambda brick: brick.placed)

    @property
    def levels(self) -> int:
        """The highest level."""
        return max((brick.level for brick in self.bricks), default=0)


def resolved_scenario(scenario: Scenario, source: Source) -> ResolvedScenario:
    """Resolve a scenario, as far as it is free of mistakes."""
    planes = tuple(planes_of(scenario))
    bricks = resolved_bricks(scenario, planes)
    schedule = scheduled(bricks, scenario, source)
    return ResolvedScenario(
        bricks=[_timed(brick, number, schedule) for number, brick in enumerate(bricks)],
        missiles=missiles_of(scenario),
        impacts=schedule.impacts,
        shaken=schedule.shaken,
        loaded=schedule.loaded,
        planes=planes,
        timing_mistakes=schedule.mistakes,
    )


def missiles_of(scenario: Scenario) -> dict[int, Brick]:
    """Return the thrown and dropped bricks by the index of the impact; an unnamed first one is `thrown-1`."""
    missiles = {}
    for number, impact in enumerate(scenario.impacts):
        missile = impact.content.missile
        if missile is not None:
            kind = missile.brick or scenario.brick
            name = missile.name or f"{missile.how}-{number + 1}"
            missiles[number] = Brick(name, kind.form.shape, kind.mass_of(kind.form))
    return missiles


def _timed(brick: ResolvedBrick, number: int, schedule: Schedule) -> ResolvedBrick:
    removed = None if brick.removed_in is None else schedule.impacts[brick.removed_in]
    return replace(brick, placed=schedule.bricks[number], removed=removed, in_hand=schedule.in_hands[number])
