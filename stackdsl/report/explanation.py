"""What was compiled, as text: the world, every brick with time, place and supports, and the systems it is played on."""

from collections.abc import Iterator, Sequence

from stability.geometry import body_axes
from stability.model import Vec3
from stackdsl.compiling.fitting import Sited, fits
from stackdsl.gathering import Case
from stackdsl.playing.systems import SYSTEMS
from stackdsl.timeline import Placement, Timeline


def explanation_text(cases: Sequence[Case]) -> str:
    """One scenario in one variant; `cases` are its systems."""
    return "\n".join(_lines(cases)) + "\n"


def _lines(cases: Sequence[Case]) -> Iterator[str]:
    scenario, timeline = cases[0].scenario, cases[0].timeline
    chosen = ", ".join(f"{name} = {text}" for name, text in cases[0].variant.parameters)
    yield f"{scenario.scenario}{f' ({chosen})' if chosen else ''}, from {cases[0].source.span_of(('scenario',))}"
    if scenario.description:
        yield f"  {scenario.description}"
    yield from _world(timeline)
    count, levels = len(timeline.placements), timeline.levels
    yield f"  {count} bricks on {levels} levels, built after {timeline.built:g} s, watched until {timeline.end:g} s"
    yield ""
    yield from _placements(timeline)
    yield ""
    for case in cases:
        yield from _system(case.system)


def _world(timeline: Timeline) -> Iterator[str]:
    world = timeline.world
    yield f"  gravity {world.gravity:g} m/s2, brick on brick friction {world.friction:g}"
    for plane in world.planes:
        normal = " ".join(f"{component:.4g}" for component in plane.normal_W)
        yield f"  {plane.id}: normal ({normal}), friction {plane.friction:g}"


def _placements(timeline: Timeline) -> Iterator[str]:
    placed = timeline.placements
    width = max(len(placement.brick.id) for placement in placed)
    sited = [Sited(placement.time, placement.brick.size, placement.pose) for placement in placed]
    for placement, fit in zip(placed, fits(sited, timeline.world.planes), strict=True):
        below = [placed[index].brick.id for index in fit.on_boxes] + (["ground or wall"] if fit.on_plane else [])
        yield (
            f"  {placement.time:8.3f} s  {placement.brick.id:<{width}}  at {_mm(placement.pose.position_W)} mm"
            f"  along {_direction(placement)}  {'dropped' if placement.drop else 'on ' + ', '.join(below)}"
        )


def _mm(position: Vec3) -> str:
    return "(" + " ".join(f"{1000.0 * part:8.2f}" for part in position) + ")"


def _direction(placement: Placement) -> str:
    """The direction of the longest side of a brick."""
    longest = max(range(3), key=lambda axis: placement.brick.size[axis])
    direction = body_axes(placement.pose.orientation)[longest]
    return "(" + " ".join(f"{round(part, 3) + 0.0:6.3f}" for part in direction) + ")"


def _system(name: str) -> Iterator[str]:
    system, engine = SYSTEMS[name], SYSTEMS[name].engine
    yield f"  {name}: {system.summary}"
    yield (
        f"    step 1/{1.0 / engine.time_step:g} s, {engine.iterations} iterations, contact ERP {engine.contact_erp:g}, "
        f"breaking threshold {1000.0 * engine.breaking_threshold:g} mm, scale {engine.scale:g}, "
        f"friction anchor {'on' if engine.friction_anchor else 'off'}, "
        f"damping {engine.linear_damping:g} linear and {engine.angular_damping:g} angular"
    )
    if system.extension:
        yield "    the extension freezes what its model finds stable; while all is frozen, time is skipped, not stepped"
    else:
        yield "    every brick is stepped all the time"
