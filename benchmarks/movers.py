"""Compares what could move the bricks that `exact` releases, on 42 scenes: error, energy, processor time, lines.

Each scene has a reference that is written apart from the engines: a closed form, `benchmarks.rigid_steps`, or Moreau's
impact law (`benchmarks.moreau`). A hit is also played with every brick awake at small steps, on `rigid` and `mujoco`.
It counts only if the impact law and `rigid` agree within 3 %; otherwise it is sensitive. `mujoco` is only shown: its
results depend on the stiffness of its contacts at any step. `exact` topples parts without an engine,
so these scenes are played with every brick awake from the start, and so are slips, rocking and landings.

Run it with `python -m benchmarks.movers`; it needs the extras `rigid` and `mujoco`, and takes about a quarter of an
hour. `--scenes column rocks` plays only the scenes whose kind or name contains one of these words.
"""

from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import pairwise
from math import acos, asin, atan, cos, degrees, inf, isfinite, pi, radians, sin, sqrt
from pathlib import Path
from pkgutil import resolve_name
from statistics import fmean, median
from time import process_time
from typing import Any, Final, TypeAlias
from unittest.mock import patch

from rich.console import Console
from rich.progress import track
from rich.table import Table
from scipy.integrate import solve_ivp

from benchmarks import collapse, end_hits, leaning_slips, slips, solids_in_engines, turned_hits, wall_hits
from benchmarks.end_hits import EndHit
from benchmarks.energy import heap
from benchmarks.figures.data import Row
from benchmarks.figures.recording import parser, record
from benchmarks.leaning_structures import Structure, askew_v, chain, structure
from benchmarks.plank_structures import LENGTH, THICKNESS
from benchmarks.rigid_engine import BARE, MASS, SIZE, column
from benchmarks.structure import code_lines
from benchmarks.turned_hits import TurnedHit
from stability.engines.rigid.settings import Solving
from stability.geometry.box import Box
from stability.geometry.solid_making import prism
from stability.geometry.vectors import about, norm, scale, turn_between
from stability.model import GROUND, BodyId, BodyState, Brick, Plane, Pose, Vec3
from stability.problem import Placed
from stackdsl.checking.cases import gather
from stackdsl.simulation.brick_tracks import BlockedPlacementError
from stackdsl.simulation.measurements import kinetic_energy
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import MOVING, MUJOCO_STIFF, PEERS, RIGID, SYSTEMS, System
from stackdsl.simulation.worlds import opened_world
from stackdsl.timeline import FixedWorld, Placement, PushAction, Timeline
from stackdsl.trace import Trace

# Values, references, systems.

GRAVITY: Final = 9.81  # [m/s2]
AGREE: Final = 0.03  # share by which the references of a hit may differ
LAW_STEPS: Final = 8000  # per second, of Moreau's impact law
NOTABLE_GAIN: Final = 0.1  # [%] of energy
STUCK: Final = "never"  # the event of the scene did not happen
REFUSED: Final = "refused"  # the run exceeded its limit of work


@dataclass(frozen=True, slots=True)
class Measured:
    """Result of one run."""

    value: float  # infinite if the event did not happen
    gain: float | None  # of energy, as a share


@dataclass(frozen=True, slots=True)
class Known:
    """Reference value of a scene."""

    value: float
    source: str
    sensitive: bool = False
    others: Mapping[str, float] = field(default_factory=dict)  # other references, by name


@dataclass(frozen=True, slots=True)
class Scene:
    """Scene with its reference, and the measurement of a run."""

    kind: str
    name: str
    known: Callable[[], Known]
    measured: Callable[[System], Measured]
    awake: bool = False  # whether every brick is awake from the start, without statics


def _exact_with(name: str, settings: Any) -> System:  # noqa: ANN401 -- of any engine
    return replace(SYSTEMS["exact"], name=name, engine=settings)


# The compared systems. Only `pybullet-exact` needs the modules in `REPAIRS`, which correct contacts of PyBullet.
ENGINES: Final = Path(__file__).parent.parent / "stability" / "engines"
REPAIRS: Final = {"edge_normals.py", "contacts.py"}
MOVERS: Final[Mapping[str, System]] = {
    "pybullet": PEERS["pybullet-exact"],
    "unrepaired": _exact_with("unrepaired", replace(MOVING, fresh_edges=False, edge_rounding=0.0, sliding_cones=False)),
    "bare": _exact_with("bare", BARE),
    "cone": _exact_with("cone", replace(BARE, maximal_coordinates=False, edge_rounding=MOVING.edge_rounding)),
    "mujoco": PEERS["mujoco-exact"],
    "rigid": SYSTEMS["exact"],
}
TOLD: Final = {
    "pybullet": "`pybullet-exact`, with all repairs",
    "unrepaired": "PyBullet, fine steps after hits, sharp boxes, no repairs of normals and friction",
    "bare": "PyBullet, sharp boxes, no repairs, no fine steps",
    "cone": "PyBullet, rounded boxes, its multibody solver with friction cones, no repairs",
    "mujoco": "MuJoCo with elliptic cones",
    "rigid": "`exact`, with the engine of this project",
}
FINELY: Final = Solving(parts=16, sweeps=50, accuracy=1e-5)
CONVERGED: Final[Mapping[str, System]] = {
    "rigid": System("fine rigid", "", replace(RIGID, time_step=0.25e-3, falling=FINELY, struck=FINELY), None),
    "mujoco": System("fine mujoco", "", replace(MUJOCO_STIFF, time_step=1 / 8000, contact_time=3e-4), None),
}

# Runs with every brick awake.

States: TypeAlias = Mapping[BodyId, BodyState]
Frames: TypeAlias = Sequence[tuple[float, States]]  # time [s], and the states of all bricks
FLOOR: Final = Plane(GROUND, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5)


def standing(bricks: Sequence[Placed], floor: Plane = FLOOR) -> Timeline:
    """Return bricks that are placed at once."""
    placements = tuple(Placement(0.0, one.brick, 1, one.pose) for one in bricks)
    return Timeline(FixedWorld(GRAVITY, floor.friction or 0.0, (floor,)), placements, hold=1.0)


def watched(scene: Timeline, system: System, until: float) -> tuple[Frames, float]:
    """Return the states of all bricks after every step, and the share by which their energy rises."""
    world = opened_world(scene, replace(system, method=None))
    bricks = {placed.brick.id: placed.brick for placed in scene.placements}
    try:
        for placed in scene.placements:
            world.add_brick(placed.brick, placed.pose)
        frames = [(0.0, world.states(list(bricks)))]
        while world.time() < until:
            fastest = max(norm(state.velocity_W) for state in frames[-1][1].values())
            world.set_max_speed(fastest + slips.LOOK * GRAVITY)
            world.step()
            frames.append((world.time(), world.states(list(bricks))))
    finally:
        world.close()
    energies = [sum(_energy(brick, states[name]) for name, brick in bricks.items()) for _, states in frames]
    return frames, max(energies) / energies[0] - 1.0


def _energy(brick: Brick, state: BodyState) -> float:
    return kinetic_energy(brick, state) + brick.mass * GRAVITY * state.pose.position_W[2]


def time_of(frames: Frames, quantity: Callable[[States], float], wanted: float) -> float:
    """Return the time at which a growing quantity reaches a value, between two steps [s]."""
    values = [(time, quantity(states)) for time, states in frames]
    for (before, less), (after, more) in pairwise(values):
        if more >= wanted:
            return before + (after - before) * (wanted - less) / (more - less)
    return inf


# Falling columns and towers: the pendulum of the falling part, until it has turned by 15 deg.


def stepped(count: int, step: float) -> Timeline:
    """Return a column of stepped planks, whose upper part falls about the edge of its lowest plank."""
    return standing([Placed(Brick(f"p{n:02}", Box(SIZE), MASS), pose) for n, pose in enumerate(column(count, step))])


def slant(scenario: str) -> Timeline:
    """Return a slant tower as high as it is when it falls."""
    case = next(case for case in gather([collapse.SCENARIO]).cases if case.identity.scenario == scenario)
    return collapse.up_to(case.timeline, collapse.LAST[scenario]["exact"])


def falls(name: str, made: Callable[[], Timeline]) -> Scene:
    """Return the scene of a part that falls as one body."""

    def measured(system: System) -> Measured:
        scene = made()
        first = {name: placed.pose for name, placed in collapse.motion_of(scene)[0].bricks.items()}

        def turned(states: States) -> float:
            return median(turn_between(pose, states[name].pose) for name, pose in first.items())

        frames, gain = watched(scene, system, 0.5)
        return Measured(time_of(frames, turned, collapse.HALF), gain)

    return Scene(
        "falling columns and towers",
        name,
        lambda: Known(collapse.rigid_time(made(), collapse.HALF), "closed form (pendulum)"),
        measured,
        awake=True,
    )


# Slips: the time in which the foot, or any corner, moves by a way.


def slides(case: slips.Case) -> Scene:
    """Return the scene of a plank that slips or slides; `slipping` integrates its equations of motion."""

    def measured(system: System) -> Measured:
        arrived = [time for time, _ in slips.passed(case, replace(system, method=None), slips.WAYS[1:2])]
        return Measured(arrived[0] if arrived else inf, None)

    name = f"{case.kind} at {case.angle:g} deg, friction {case.share:g} of the needed, yaw {case.yaw:g} deg"
    return Scene(
        "slips", name, lambda: Known(case.truth(slips.WAYS[1])[0], "equations of motion (slipping)"), measured, True
    )


def slips_of(family: Callable[..., Structure | None], number: int) -> Scene:
    """Return the scene of a random leaning structure with a tenth less friction than it needs."""

    def made() -> tuple[Structure, float]:
        leaning = structure(family, number)
        needed = leaning_slips.needed_friction(leaning)
        assert needed is not None, "the structure must slip for lack of friction"
        return leaning, 0.9 * needed

    def measured(system: System) -> Measured:
        times = leaning_slips.played(*made(), replace(system, method=None), leaning_slips.LONGEST)
        return Measured(times[0], None)

    return Scene(
        "slips",
        f"{family.__name__} {number}, friction 0.9 of the needed",
        lambda: Known(leaning_slips.reference(*made()).due[0], "rigid_steps"),
        measured,
        awake=True,
    )


# Hits: the shift of the struck plank.


@dataclass(frozen=True, slots=True)
class SideHit(TurnedHit):
    """Plank that comes end-on at the long side of a plank of any level, exactly level."""

    level: int = 1

    @property
    def struck(self) -> int:
        return 2 * self.level - 1

    def thrown(self) -> tuple[Placed, Vec3]:
        shot, velocity_W = TurnedHit.thrown(self)
        x, y, _ = shot.pose.position_W
        return replace(shot, pose=replace(shot.pose, position_W=(x, y, (self.level - 0.5) * THICKNESS))), velocity_W


def shift_of(trace: Trace, struck: int) -> float:
    """Return the shift of a brick [m], by its number in the order of placement."""
    return list(trace.tracks.values())[struck].shift


def gain_of(trace: Trace) -> float | None:
    """Return the share by which the energy of the moving bricks rose."""
    return trace.energy.gain if trace.energy is not None else None


def sooner(scene: Timeline) -> Timeline:
    """Return a throw a little after the start, followed for a shorter time."""
    return replace(scene, actions=tuple(replace(each, time=min(each.time, 0.05)) for each in scene.actions), hold=0.4)


def converged(scene: Timeline, struck: int) -> dict[str, float]:
    """Return the shift with every brick awake at small steps, by engine [m]."""
    return {name: shift_of(play(sooner(scene), system), struck) for name, system in CONVERGED.items()}


def agreed(found: Mapping[str, float], law: float | None = None) -> Known:
    """Return the impact law, compared with fine `rigid`; without it, the mean of both engines at small steps."""
    pair = list(found.values()) if law is None else [found["rigid"], law]
    sensitive = max(pair) > (1.0 + AGREE) * min(pair)
    if law is None:
        return Known(fmean(pair), "`rigid` and `mujoco` at small steps", sensitive, found)
    return Known(law, "impact law (moreau)", sensitive, found)


def hits(kind: str, name: str, scene: Timeline, struck: int, law: Callable[[], float]) -> Scene:
    """Return the scene of a hit on a tower."""

    def measured(system: System) -> Measured:
        trace = play(scene, system)
        return Measured(shift_of(trace, struck), gain_of(trace))

    return Scene(kind, name, lambda: agreed(converged(scene, struck), law()), measured)


def side(level: int, speed: float) -> Scene:
    """Return a throw at the long side of a plank of a tower of 13 levels."""
    hit = SideHit(turn=0.0, speed=speed, above=0.0, levels=13, level=level)
    law = partial(turned_hits.by_impact_law, hit, LAW_STEPS)
    return hits("hits onto long sides", f"level {level}, {speed:g} m/s", turned_hits.timeline(hit), hit.struck, law)


def end(name: str, hit: EndHit) -> Scene:
    """Return a throw at the end of a plank of level 3 of 13."""
    law = partial(end_hits.referred, hit, LAW_STEPS)
    return hits("hits onto ends", f"{name}, {hit.speed:g} m/s", end_hits.timeline(hit), end_hits.STRUCK, law)


def turned(turn: float, speed: float) -> Scene:
    """Return a throw of a turned plank at the top of a tower of 7 levels, 0.5 mm above level; 90 deg is broadside."""
    hit = TurnedHit(turn, speed)
    law = partial(turned_hits.by_impact_law, hit, LAW_STEPS)
    return hits("broadside and turned hits", f"{turn:g} deg, {speed:g} m/s", turned_hits.timeline(hit), hit.struck, law)


def in_wall(thrown: bool) -> Scene:
    """Return a push or hit in the middle of a wall of 40 courses: a closed form."""
    courses, abreast, course = wall_hits.WALLS[0]
    bricks = wall_hits.placed(courses, abreast)
    target = wall_hits.middle_of(course, bricks)
    scene = wall_hits.thrown_at(bricks, target, 4.0) if thrown else wall_hits.pushed(bricks, target, 2.0)

    def measured(system: System) -> Measured:
        trace = play(scene, system)
        return Measured(trace.tracks[target.brick.id].shift, gain_of(trace))

    due = 1e-3 * wall_hits.way_mm(courses - course, 2.0, 2 if thrown else 1)
    name = "hit at 4 m/s" if thrown else "pushed to 2 m/s"
    return Scene("walls", f"plank in 790, {name}", lambda: Known(due, "closed form (friction)"), measured)


# Heaps: energy alone, since where their bricks end up is random.


def heaps(number: int) -> Scene:
    """Return a random heap; odd numbers have slivers."""

    def measured(system: System) -> Measured:
        trace = play(heap(number), system)
        return Measured(0.0, gain_of(trace))

    kind = "heaps with slivers" if number % 2 else "heaps"
    return Scene(kind, f"heap {number}", lambda: Known(0.0, "no energy gained"), measured)


# Dominoes: the time of the wave from the third to the eleventh of twelve, and how many of twenty fall.

APART, LEAN, TURNED = 0.03, radians(6.0), radians(5.0)  # [m], lean of the first, turn at which one counts as reached
Y: Final = (0.0, 1.0, 0.0)


def on_end(count: int, lean: float = 0.0) -> list[Placed]:
    """Return planks on end in a row, the first of which leans towards the others, on its edge."""
    along, across = 0.5 * LENGTH, 0.5 * THICKNESS
    first = Pose(
        (across + along * sin(lean) - across * cos(lean), 0.0, along * cos(lean) + across * sin(lean)),
        about(Y, 0.5 * pi + lean),
    )
    poses = [first, *(Pose((APART * n, 0.0, along), about(Y, 0.5 * pi)) for n in range(1, count))]
    return [Placed(Brick(f"d{n:02}", Box(SIZE), MASS), pose) for n, pose in enumerate(poses)]


def wave(system: System) -> Measured:
    """Return the time in which the wave passes eight dominoes [s]."""
    row = on_end(12, LEAN)
    frames, gain = watched(standing(row), system, 0.75)

    def reached(one: Placed) -> float:
        return time_of(frames, lambda states: turn_between(one.pose, states[one.brick.id].pose), TURNED)

    return Measured(reached(row[10]) - reached(row[2]), gain)


def all_fall(system: System) -> Measured:
    """Return how many of twenty dominoes fall after a push on the first."""
    push = PushAction(0.2, "d00", (2e-3, 0.0, 0.0), (0.0, 0.0, 0.05))
    scene = standing(on_end(20))
    trace = play(replace(scene, actions=(*scene.actions, push), hold=1.5), system)
    return Measured(sum(one.tilt > 0.25 * pi for one in trace.tracks.values()), gain_of(trace))


# Rolling, rocking, landing.

FACES, RADIUS, SLOPE = 3, 0.02, radians(17.0)  # of a prism of twelve faces
EDGE = radians(15.0)  # half the angle of a face


def rolls(system: System) -> Measured:
    """Return the time in which a prism of twelve faces rolls over three of them, down a slope [s]."""
    up_W = (sin(SLOPE), 0.0, cos(SLOPE))
    outline = [(RADIUS * cos(EDGE * k), RADIUS * sin(EDGE * k)) for k in range(-7, 17, 2)]
    start = Pose(scale(RADIUS * cos(EDGE), up_W), about(Y, SLOPE))
    roller = Placed(Brick("roller", prism(outline, 0.05).shape, 1.0), start)
    frames, gain = watched(standing([roller], Plane(GROUND, (0.0, 0.0, 0.0), up_W, 2.0)), system, 0.4)
    return Measured(
        time_of(frames, lambda states: turn_between(start, states["roller"].pose), 2.0 * EDGE * FACES), gain
    )


def rolling_time() -> float:
    """Return this time if every landing on a face is plastic, about the next edge [s]."""
    inertia = (2.0 + cos(2.0 * EDGE)) / 6.0 + 1.0  # about an edge, by m R^2
    rate, time = 0.0, 0.0

    def motion(_: float, state: Sequence[float]) -> list[float]:
        return [state[1], GRAVITY / RADIUS / inertia * sin(state[0])]

    def landing(_: float, state: Sequence[float]) -> float:
        return state[0] - SLOPE - EDGE

    for _ in range(FACES):
        course = solve_ivp(motion, (0.0, 0.5), [SLOPE - EDGE, rate], events=landing, rtol=1e-10, atol=1e-12)
        time += course.t_events[0][0]
        rate = course.y_events[0][0][1] * (inertia - 2.0 * sin(EDGE) ** 2) / inertia
    return time


def housner(width: float, tilt: float, count: int) -> list[float]:
    """Return how far a block of 100 mm that is let go at a tilt [deg] rises after each of some landings [deg].

    Each leaves 1 - 1.5 sin^2 of the angular velocity, about the other edge (Housner, 1963).
    """
    slender = atan(width / 0.1)
    kept = 1.0 - 1.5 * sin(slender) ** 2
    energy, risen = cos(slender - radians(tilt)) - cos(slender), []
    for _ in range(count):
        energy *= kept**2
        risen.append(degrees(slender - acos(energy + cos(slender))))
    return risen


def rocks(width: float, tilt: float) -> Scene:
    """Return a block of 100 mm that rocks: how far it rises beyond its first landing [deg]."""
    lean = radians(tilt)
    middle = (0.0, 0.0, 0.5 * (0.1 * cos(lean) + width * sin(lean)))
    block = Placed(Brick("block", Box((width, 0.03, 0.1)), MASS), Pose(middle, about(Y, lean)))
    scene = standing([block], replace(FLOOR, friction=1.0))

    def measured(system: System) -> Measured:
        frames, gain = watched(scene, system, 0.4)
        tilts = [2.0 * asin(states["block"].pose.orientation[1]) for _, states in frames]
        return Measured(-min(tilts) * 180.0 / pi, gain)

    name = f"block {1000.0 * width:g} mm wide rocks from {tilt:g} deg"
    return Scene(
        "rolling, rocking, landing", name, lambda: Known(housner(width, tilt, 1)[0], "Housner"), measured, True
    )


def lands(tilt: float, height: float) -> Scene:
    """Return a tilted plank that falls onto its edge on a smooth floor: its rate when half of the tilt is left."""
    a, c, lean = 0.5 * LENGTH, 0.5 * THICKNESS, radians(tilt)

    def level(angle: float) -> float:  # of the centre above the floor
        return a * sin(angle) + c * cos(angle)

    def lever(angle: float) -> float:  # horizontal, from the centre to the edge
        return a * cos(angle) - c * sin(angle)

    def rate() -> float:
        own = (a * a + c * c) / 3.0  # moment of inertia by mass
        after = lever(lean) * sqrt(2.0 * GRAVITY * height) / (own + lever(lean) ** 2)  # a plastic impact at the edge
        energy = 0.5 * (own + lever(lean) ** 2) * after**2 + GRAVITY * (level(lean) - level(0.5 * lean))
        return sqrt(2.0 * energy / (own + lever(0.5 * lean) ** 2))

    start = Pose((0.0, 0.0, level(lean) + height), about(Y, lean))
    scene = standing([Placed(Brick("plank", Box(SIZE), MASS), start)], replace(FLOOR, friction=0.0))

    def measured(system: System) -> Measured:
        frames, gain = watched(scene, system, sqrt(2.0 * height / GRAVITY) + 0.1)
        for _, states in frames:
            if 2.0 * asin(states["plank"].pose.orientation[1]) < 0.5 * lean:
                return Measured(-states["plank"].angular_velocity_W[1], gain)
        return Measured(inf, gain)

    name = f"plank tilted by {tilt:g} deg falls {1000.0 * height:g} mm onto its edge"
    return Scene("rolling, rocking, landing", name, lambda: Known(rate(), "closed form (impact)"), measured, True)


# Solids: verdicts of exact statics.


def solids(first: int, count: int) -> Scene:
    """Return random assemblies of solids, placed at once: how many of them stand or fall as statics says."""
    clear = [case for case in solids_in_engines.cases(range(first, first + count)) if case is not None]

    def measured(system: System) -> Measured:
        runs = [solids_in_engines.played(case, replace(system, method=None)) for case in clear]
        return Measured(sum(run.stands == run.case.stands for run in runs), max(run.gain for run in runs))

    name = f"verdicts of {len(clear)} assemblies from {first} on"
    return Scene("solids", name, lambda: Known(len(clear), "exact statics"), measured, awake=True)


def scenes() -> Sequence[Scene]:
    """Return the scenes. Those of solids are judged by statics first, which takes a while."""
    return (*scenes_of_boxes(), solids(0, 30), solids(100, 30))


def scenes_of_boxes() -> Sequence[Scene]:
    """Return the scenes without random solids."""
    return (
        *(falls(f"column of {n} planks stepped by {1000.0 * s:g} mm", partial(stepped, n, s)) for n, s in COLUMNS),
        *(falls(name, partial(slant, name)) for name in collapse.LAST),
        slides(slips.Case("ladder", 60.0, 0.97, 30.0)),
        slides(slips.Case("V", 60.0, 0.90, 30.0)),
        slides(slips.Case("slope", 26.6, 0.97, 45.0)),
        slips_of(askew_v, 1),
        slips_of(chain, 1),
        side(3, 1.0),
        side(3, 2.0),
        side(3, 4.0),
        side(13, 1.0),
        side(13, 2.5),
        end("level", EndHit(4.0)),
        end("2 mm higher", EndHit(1.0, above=2e-3)),
        end("0.2 mm lower", EndHit(2.0, above=-2e-4)),
        end("4 mm aside, 1 mm higher, askew by 8 deg", EndHit(3.0, 4e-3, 1e-3, radians(8.0))),
        turned(90.0, 1.0),
        turned(90.0, 3.0),
        turned(60.0, 2.0),
        turned(45.0, 1.0),
        in_wall(thrown=False),
        in_wall(thrown=True),
        *map(heaps, (370, 642, 126, 985, 1, 5)),
        Scene(
            "dominoes",
            "wave along 8 of 12",
            lambda: agreed({n: wave(s).value for n, s in CONVERGED.items()}),
            wave,
            True,
        ),
        Scene(
            "dominoes", "20 after a push: fallen", lambda: Known(20.0, "each pushes the next over its edge"), all_fall
        ),
        Scene(
            "rolling, rocking, landing",
            "prism of 12 faces rolls over 3",
            lambda: Known(rolling_time(), "closed form (plastic landings)"),
            rolls,
            True,
        ),
        rocks(0.03, 4.0),
        rocks(0.05, 4.0),
        lands(10.0, 0.05),
        lands(40.0, 0.02),
    )


# Numbers and steps of planks, each with the centre of the falling part 3 to 13 mm beyond its edge.
COLUMNS: Final = ((10, 0.013), (8, 0.0155), (6, 0.022), (5, 0.026), (12, 0.0104))


# Runs.


@contextmanager
def engine_clock(system: System) -> Iterator[list[float]]:
    """Count the processor time [s] and the number of the steps of an engine, with what its adapter adds to them."""
    world, spent = resolve_name(system.engine.world), [0.0, 0.0]
    step = world.step

    def timed(*arguments: Any, **named: Any) -> None:  # noqa: ANN401 -- those of `step`
        began = process_time()
        step(*arguments, **named)
        spent[0] += process_time() - began
        spent[1] += 1

    with patch.object(world, "step", timed):
        yield spent


def compared(scene: Scene, movers: Mapping[str, System]) -> dict[str, Any]:
    """Play one scene with all engines; return its row."""
    known = scene.known()
    row: dict[str, Any] = {
        "kind": scene.kind,
        "awake": scene.awake,
        "source": known.source,
        "reference": float(known.value),
        "sensitive": bool(known.sensitive),
        **{f"fine_{name}": known.others.get(name) for name in CONVERGED},
    }
    for name, system in movers.items():
        began = process_time()
        with engine_clock(system) as spent:
            try:
                found: Measured | None = scene.measured(system)
            except BlockedPlacementError:  # the steps that this engine needs exceed the limit of work
                found = None
        percent, text = _error(found, known)
        row |= {
            f"{name}_value": None if found is None else float(found.value),
            f"{name}_percent": percent,
            f"{name}_error": text,
            f"{name}_gain_percent": None if found is None or found.gain is None else float(100.0 * found.gain),
            f"{name}_s": process_time() - began,
            f"{name}_engine_s": spent[0],
            f"{name}_steps": int(spent[1]),
        }
    return row


def _error(found: Measured | None, known: Known) -> tuple[float | None, str | None]:
    """Return the error of a run [%], if it has one, and as a text."""
    if found is None or not isfinite(found.value):
        return None, REFUSED if found is None else STUCK
    if known.value == 0.0 or known.sensitive:
        return None, "sensitive" if known.sensitive else None  # in a heap only energy counts
    percent = float(100.0 * (found.value / known.value - 1.0))
    return percent, f"{percent:+.1f} %"


def by_kind(rows: Mapping[str, Mapping[str, Any]]) -> dict[str, Row]:
    """Return for each kind of scenes the largest error and the processor time, for each engine."""
    kinds: dict[str, list[Mapping[str, Any]]] = defaultdict(list)
    for row in rows.values():
        kinds[row["kind"]].append(row)
    return {
        kind: {
            "scenes": len(of_kind),
            **{
                f"{name}_worst": _worst([(row[f"{name}_percent"], row[f"{name}_error"]) for row in of_kind])
                for name in MOVERS
            },
            **{f"{name}_gain_percent": _most([row[f"{name}_gain_percent"] for row in of_kind]) for name in MOVERS},
            **{f"{name}_s": sum(row[f"{name}_s"] for row in of_kind) for name in MOVERS},
        }
        for kind, of_kind in kinds.items()
    }


def _worst(errors: Sequence[tuple[float | None, str | None]]) -> str | None:
    for failure in (REFUSED, STUCK):
        if failure in (text for _, text in errors):
            return failure
    worst = max((abs(percent) for percent, _ in errors if percent is not None), default=None)
    return None if worst is None else f"{worst:.1f} %"


def _most(gains: Sequence[float | None]) -> float | None:
    return max((gain for gain in gains if gain is not None), default=None)


def by_mover(rows: Mapping[str, Mapping[str, Any]]) -> dict[str, Row]:
    """Return for each engine the errors, the energy, the processor time and the lines of code."""
    bare = {name: row["bare_engine_s"] / max(row["bare_steps"], 1) for name, row in rows.items()}
    found: dict[str, Row] = {}
    for name in MOVERS:
        judged = [abs(row[f"{name}_percent"]) for row in rows.values() if row[f"{name}_percent"] is not None]
        failed = sum(row[f"{name}_error"] in {STUCK, REFUSED} for row in rows.values())
        gains = [row[f"{name}_gain_percent"] for row in rows.values()]
        steps = sum(row[f"{name}_steps"] for row in rows.values())
        engine_s = sum(row[f"{name}_engine_s"] for row in rows.values())
        as_bare_s = sum(row[f"{name}_steps"] * bare[scene] for scene, row in rows.items())
        found[name] = {
            "mover": TOLD[name],
            "judged": len(judged) + failed,
            "median_percent": median(judged) if judged else None,
            "over_3_percent": sum(error > 100.0 * AGREE for error in judged) + failed,
            "gained": sum(gain is not None and gain > NOTABLE_GAIN for gain in gains),
            "gain_percent": _most(gains),
            "steps": steps,
            "step_ms": 1000.0 * engine_s / max(steps, 1),
            "times_bare": engine_s / as_bare_s if as_bare_s else None,
            "engine_s": engine_s,
            "s": sum(row[f"{name}_s"] for row in rows.values()),
            "lines": lines_of(name),
        }
    return found


def lines_of(name: str) -> int:
    """Return the lines of code that an engine needs of its own; friction cones of PyBullet stay in `stepping.py`."""
    room = name if name in {"mujoco", "rigid"} else "pybullet"
    files = [*(ENGINES / room).glob("*.py"), *([ENGINES / "edge_normals.py"] if room == "pybullet" else [])]
    needed = [file for file in files if name == "pybullet" or file.name not in REPAIRS]
    return sum(code_lines(file.read_text(encoding="utf-8")) for file in needed)


def main() -> None:
    """Play and print the tables; write them on request."""
    arguments = parser(__doc__)
    arguments.add_argument("--scenes", nargs="+", default=[""], help="words of the kinds or names of scenes to play")
    chosen = arguments.parse_args()
    progress, console = Console(stderr=True, width=150), Console(width=170)
    asked = [one for one in scenes() if any(word in f"{one.kind}: {one.name}" for word in chosen.scenes)]
    for system in (*MOVERS.values(), *CONVERGED.values()):
        watched(stepped(3, 0.01), system, 0.01)  # so that compiling counts for no scene
        play(standing(on_end(1)), system)
    rows: dict[str, dict[str, Any]] = {}
    for scene in track(asked, "scenes", console=progress):
        rows[f"{scene.kind}: {scene.name}"] = row = compared(scene, MOVERS)
        fine = " ".join(f"{name} {row[f'fine_{name}']:.4g}" for name in CONVERGED if row[f"fine_{name}"] is not None)
        progress.print(f"{scene.kind}: {scene.name}: {row['reference']:.4g} {fine}")
        for name in MOVERS:
            progress.print(f"    {name} {row[f'{name}_value']} {row[f'{name}_error']} {row[f'{name}_s']:.2g} s")
    kinds, movers = by_kind(rows), by_mover(rows)
    for title, of in (("by kind", kinds), ("by engine", movers)):
        table = Table("", *next(iter(of.values())), title=title)
        for name, values in of.items():
            table.add_row(name, *map(_shown, values.values()))
        console.print(table)
    if chosen.write:
        record("movers", "python -m benchmarks.movers --write", {"scenes": rows, "kinds": kinds, "movers": movers})


def _shown(value: object) -> str:
    return f"{value:.3g}" if isinstance(value, float) else str(value)


if __name__ == "__main__":
    main()
