"""What was compiled, as text: the world, every brick with time, place and supports, and the systems it is played on.

Where `exact` is one of them: which stage proved each placement, what that would survive, or what would mend a fall.
"""

from collections.abc import Iterator, Mapping, Sequence
from math import hypot, inf

from stability.friction_law import law_of
from stability.geometry.rotations import body_axes
from stability.geometry.touching import TOUCHING, reach_between
from stability.geometry.vectors import scale
from stability.model import GROUND, BodyId, Brick, Vec3
from stackdsl.checking.gathering import Case
from stackdsl.compiling.fitting import Fit, Sited, fits
from stackdsl.judging.knobs import Knobs
from stackdsl.judging.proofs import proofs_of
from stackdsl.report.modified_text import modified_text
from stackdsl.report.proof_text import Extent, proven_lines, stages_told
from stackdsl.report.rubbing_text import rubbing_lines
from stackdsl.shown_text import without_commands
from stackdsl.systems.known_systems import system_named
from stackdsl.systems.modification import as_played
from stackdsl.systems.systems import Method
from stackdsl.systems.worlds import settings_for
from stackdsl.timeline import Arrival, Hold, LetGo, Move, Placement, Push, Removal, Shake, Timeline
from stackdsl.wording import moving_text, shaking_text

AXES: tuple[Vec3, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def explanation_text(cases: Sequence[Case], extent: Extent = Extent()) -> str:  # noqa: B008 -- frozen
    """One scenario in one variant; `cases` are its systems."""
    return without_commands("\n".join(_lines(cases, extent)) + "\n")


def _lines(cases: Sequence[Case], extent: Extent) -> Iterator[str]:
    scenario, timeline = cases[0].scenario, cases[0].timeline
    chosen = ", ".join(f"{name} = {text}" for name, text in cases[0].variant.parameters)
    yield f"{scenario.scenario}{f' ({chosen})' if chosen else ''}, from {cases[0].source.span_of(('scenario',))}"
    if scenario.description:
        yield f"  {' '.join(scenario.description.split())}"
    yield from _world(timeline)
    count, levels = sum(not placement.hits for placement in timeline.placements), timeline.levels
    what = f"{count} brick{'s' * (count > 1)} on {levels} level{'s' * (levels > 1)}"
    yield f"  {what}, built after {timeline.built:g} s, watched until {timeline.end:g} s"
    yield ""
    proofs = proofs_of(timeline) if any(system_named(case.system).method is Method.PROVEN for case in cases) else None
    yield from _actions(timeline, stages_told(proofs, extent.times) if proofs is not None else {})
    yield ""
    if proofs is not None:
        knobs = Knobs(scenario, cases[0].variant)
        yield from proven_lines(proofs, timeline, count, extent, knobs)
        yield ""
    for case in cases:
        yield from _system(case.system, timeline)


def _world(timeline: Timeline) -> Iterator[str]:
    world = timeline.world
    yield f"  gravity {world.gravity:g} m/s2, brick on brick friction {law_of(world.friction).usual:g}"
    yield from rubbing_lines(timeline)
    for plane in world.planes:
        normal = " ".join(f"{round(component, 4) + 0.0:g}" for component in plane.normal_W)
        yield f"  {plane.id}: normal ({normal}), friction {plane.friction:g}"


def _actions(timeline: Timeline, told: Mapping[BodyId, str]) -> Iterator[str]:
    """One line a brick set down, with what `told` says of it, and one each other action."""
    placed = timeline.placements
    width = max(len(placement.brick.id) for placement in placed)
    bricks, planes = [placement.brick for placement in placed], [plane.id for plane in timeline.world.planes]
    found = iter(zip(placed, fits(_sited(timeline), timeline.world.planes), strict=True))
    for action in timeline.actions:
        match action:
            case Removal():
                yield f"  {action.time:8.3f} s  {', '.join(action.bricks):<{width}}  pulled out"
            case Push():
                impulse = " ".join(f"{1000.0 * part:.4g}" for part in action.impulse_W)
                yield f"  {action.time:8.3f} s  {action.brick:<{width}}  pushed by ({impulse}) mN*s"
            case Shake():
                yield f"  {action.time:8.3f} s  {GROUND:<{width}}  shaken {shaking_text(action.motion)}"
            case Move(lowers=False):
                yield f"  {action.time:8.3f} s  {action.brick:<{width}}  {moving_text(action.course)} by hand"
            case Hold():
                yield f"  {action.time:8.3f} s  {', '.join(action.bricks):<{width}}  held"
            case LetGo():
                yield f"  {action.time:8.3f} s  {', '.join(action.bricks):<{width}}  let go"
            case Placement():
                placement, fit = next(found)
                yield (
                    f"  {placement.time:8.3f} s  {placement.brick.id:<{width}}  "
                    f"at {_mm(placement.pose.position_W)} mm  along {_direction(placement)}  "
                    f"{_footing(placement, fit, bricks, planes)}{told.get(placement.brick.id, '')}"
                )


def _footing(placement: Placement, fit: Fit, bricks: Sequence[Brick], planes: Sequence[BodyId]) -> str:
    """On what a brick is set down, and which walls it touches; or how else it comes."""
    if placement.arrival in (Arrival.LET_GO, Arrival.DROPPED):
        return "dropped"
    if placement.arrival is Arrival.THROWN:
        return f"thrown at {hypot(*placement.velocity_W):.4g} m/s"
    boxes = [bricks[index] for index in fit.on_boxes]
    below = [*(brick.id for brick in boxes), *(planes[index] for index in fit.on_planes)]
    walls = [planes[index] for index in fit.beside_planes]
    if not below:
        return "between " + ", ".join([*(bricks[index].id for index in fit.beside_boxes), *walls])
    through = _touched_through(placement.brick, boxes) if len(below) > 1 else ""
    by_hand = ", brought by hand" if placement.arrival is Arrival.BY_HAND else ""
    return f"on {', '.join(below)}{through}" + (f", against {', '.join(walls)}" if walls else "") + by_hand


def _touched_through(brick: Brick, boxes: Sequence[Brick]) -> str:
    """Which of the boxes below are too thin to keep a brick off what they lie on."""
    reach = reach_between(brick.shape.least_thickness)
    sheets = [box.id for box in boxes if box.shape.least_thickness <= reach]
    share = f"{100.0 * TOUCHING:g} % of {brick.id}"
    return f" (touched through {', '.join(sheets)}, thinner than {share})" if sheets else ""


def _sited(timeline: Timeline) -> list[Sited]:
    """All bricks, each from the moment when it is placed until the one when it is pulled out."""
    moments = list(timeline.moments())
    until = {
        name: float(turn)
        for turn, moment in enumerate(moments)
        if isinstance(moment, Removal)
        for name in moment.bricks
    }
    return [
        Sited(float(turn), placement.brick.shape, placement.pose, until.get(placement.brick.id, inf))
        for turn, moment in enumerate(moments)
        if isinstance(moment, tuple)
        for placement in moment
    ]


def _mm(position: Vec3) -> str:
    return "(" + " ".join(f"{1000.0 * part:8.2f}" for part in position) + ")"


def _direction(placement: Placement) -> str:
    """The direction of the longest side of a brick."""
    reach = placement.brick.shape.reach
    longest = max(range(3), key=lambda axis: reach(AXES[axis]) + reach(scale(-1.0, AXES[axis])))
    direction = body_axes(placement.pose.orientation)[longest]
    return "(" + " ".join(f"{round(part, 3) + 0.0:6.3f}" for part in direction) + ")"


def _system(name: str, timeline: Timeline) -> Iterator[str]:
    system = system_named(name)
    yield f"  {name}: {system.summary}"
    yield f"    {settings_for(as_played(timeline, system.modification), system).summary()}"
    if modified := system.modification.summary:
        yield f"    {modified_text(modified)}"
    if system.method is Method.PROVEN:
        yield "    what statics proves to stand is frozen; there is no engine until something moves"
    elif system.method is Method.PUBLISHED:
        yield "    the extension freezes what its model finds stable; while all is frozen, time is skipped, not stepped"
    else:
        yield "    every brick is stepped all the time"
