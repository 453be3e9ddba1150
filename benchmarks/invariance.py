"""Compares what a push, a hit or a pull does to a tower or wall with the same scene transformed.

The result must not depend on the place of a scene, its direction, its size (with times by Froude), the names and the
order of its bricks, or on a structure that stands apart. Limits: the shift of the pushed plank changes by 0.5 %, that
of any other by 2 % of its own. Run it with `python -m benchmarks.invariance`.
"""

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from math import radians, sqrt
from random import Random
from typing import Final

from rich.console import Console
from rich.progress import track
from rich.table import Table

from benchmarks import end_hits, turned_hits, wall_hits
from benchmarks.end_hits import EndHit
from benchmarks.figures.data import Row
from benchmarks.figures.recording import parser, record
from benchmarks.movers import SideHit
from benchmarks.plank_structures import four_stack
from benchmarks.turned_hits import TurnedHit
from stability.dynamics.ground_motion import HandCourse
from stability.geometry.box import Box
from stability.geometry.vectors import about, add, multiply, rotate, scale
from stability.model import BodyId, Brick, Pose, Quaternion, Vec3
from stackdsl.simulation.runner import play
from stackdsl.simulation.systems import PEERS, SYSTEMS, System
from stackdsl.timeline import Action, MoveAction, Placement, PushAction, ReleaseAction, Timeline
from stackdsl.trace import BrickState

PUSHED, OTHER = 0.5, 2.0  # [%] limits of the change of a shift
NOTICED = 1e-5  # [m] least shift of another plank that counts
COMPARED: Final[Mapping[str, System]] = {
    "exact": SYSTEMS["exact"],
    "rigid": PEERS["rigid"],
    "mujoco": PEERS["mujoco-exact"],
    "pybullet": PEERS["pybullet-exact"],
}

# Scenes.


@dataclass(frozen=True, slots=True)
class Scene:
    """Structure with a disturbance."""

    timeline: Timeline
    pushed: BodyId


LEVELS, LEVEL, SPEED, EARLY = 13, 3, 2.0, 0.05  # planks high, the disturbed one, [m/s], time of the disturbance [s]


def tower(*actions: Action) -> Scene:
    """Return a tower, with these actions on a plank of level 3."""
    hit = turned_hits.timeline(SideHit(0.0, 1.0, 0.0, LEVELS, level=LEVEL))
    return Scene(replace(hit, actions=(*hit.placements[:-1], *actions)), PLANK.id)


PLANK: Final[Brick] = four_stack(2 * LEVEL)[-1].brick  # lies along x, at y > 0
TO_SPEED: Final = (0.0, -SPEED * PLANK.mass, 0.0)  # [N s]


def hit_at(timeline: Timeline, struck: int) -> Scene:
    """Return a hit, a little after the start."""
    actions = tuple(replace(action, time=min(action.time, EARLY)) for action in timeline.actions)
    return Scene(replace(timeline, actions=actions, hold=0.5), timeline.placements[struck].brick.id)


def pulled() -> Scene:
    """Return a tower from which a hand slides a plank by a quarter of its length."""
    course = HandCourse(((0.03, 0.0, 0.0),), 0.1)
    move = MoveAction(EARLY, PLANK.id, course, free_W=(0.0, 0.0, 1.0))
    return tower(move, ReleaseAction(EARLY + course.duration, (PLANK.id,)))


def wall(thrown: bool) -> Scene:
    """Return a wall of 20 courses with a hit or a push in the middle."""
    bricks = wall_hits.placed(20, 10)
    target = wall_hits.middle_of(8, bricks)
    scene = wall_hits.thrown_at(bricks, target, 2.0 * SPEED) if thrown else wall_hits.pushed(bricks, target, SPEED)
    return hit_at(scene, bricks.index(target))


SCENES: Final[Mapping[str, Callable[[], Scene]]] = {
    "tower, plank pushed": lambda: tower(PushAction(EARLY, PLANK.id, TO_SPEED)),
    "tower, plank pushed off its middle": lambda: tower(PushAction(EARLY, PLANK.id, TO_SPEED, (0.02, 0.0, 0.0))),
    "tower, plank thrown end-on": lambda: hit_at(
        turned_hits.timeline(SideHit(0.0, SPEED, 0.0, LEVELS, level=LEVEL)), 5
    ),
    "tower, plank thrown askew at an end": lambda: hit_at(end_hits.timeline(EndHit(SPEED, 4e-3, 1e-3, 0.14)), 5),
    "tower, plank thrown at the top, turned by 60 deg": lambda: hit_at(
        turned_hits.timeline(TurnedHit(60.0, SPEED)), 13
    ),
    "tower, plank pulled": pulled,
    "wall, plank pushed": lambda: wall(thrown=False),
    "wall, plank thrown end-on": lambda: wall(thrown=True),
}

# Transformations.


@dataclass(frozen=True, slots=True)
class Change:
    """Transformed scene, with the names of its bricks."""

    scene: Scene
    names: Mapping[BodyId, BodyId]  # new ones by old
    larger: float = 1.0  # factor of lengths


def moved(scene: Scene, place: Callable[[Vec3], Vec3], turn: Callable[[Quaternion], Quaternion]) -> Change:
    """Return a scene whose vectors are transformed by a linear map, and its orientations."""

    def changed(action: Action) -> Action:
        match action:
            case Placement():
                pose = Pose(place(action.pose.position_W), turn(action.pose.orientation))
                return replace(action, pose=pose, velocity_W=place(action.velocity_W))
            case PushAction():
                return replace(action, impulse_W=place(action.impulse_W), offset_W=place(action.offset_W))
            case MoveAction():
                course = replace(action.course, places_W=tuple(map(place, action.course.places_W)))
                return replace(action, course=course, free_W=action.free_W and place(action.free_W))
        return action

    return _same_names(scene, tuple(map(changed, scene.timeline.actions)))


def _same_names(scene: Scene, actions: tuple[Action, ...], larger: float = 1.0) -> Change:
    names = {one.brick.id: one.brick.id for one in scene.timeline.placements}
    return Change(replace(scene, timeline=replace(scene.timeline, actions=actions)), names, larger)


def turned(degrees: float, scene: Scene) -> Change:
    """Return a scene rotated about the vertical."""
    turn = about((0.0, 0.0, 1.0), radians(degrees))
    return moved(scene, partial(rotate, turn), partial(multiply, turn))


def mirrored(axis: int, scene: Scene) -> Change:
    """Return a scene mirrored along an axis; boxes are their own mirror images."""

    def place(vector: Vec3) -> Vec3:
        x, y, z = vector
        return (-x, y, z) if axis == 0 else (x, -y, z)

    def turn(orientation: Quaternion) -> Quaternion:
        x, y, z, w = orientation
        return (x, -y, -z, w) if axis == 0 else (-x, y, -z, w)

    return moved(scene, place, turn)


def translated(by: Vec3, scene: Scene) -> Change:
    """Return a scene at another place."""

    def changed(action: Action) -> Action:
        if not isinstance(action, Placement):
            return action
        return replace(action, pose=_shifted(action.pose, by))

    return _same_names(scene, tuple(map(changed, scene.timeline.actions)))


def _shifted(pose: Pose, by: Vec3) -> Pose:
    return replace(pose, position_W=add(pose.position_W, by))


def enlarged(factor: float, scene: Scene) -> Change:
    """Return a scene with other lengths, at the same density and gravity: times grow with their root (Froude)."""
    longer = sqrt(factor)

    def changed(action: Action) -> Action:
        match action:
            case Placement():
                brick = replace(action.brick, shape=_box(action.brick, factor), mass=factor**3 * action.brick.mass)
                pose = replace(action.pose, position_W=scale(factor, action.pose.position_W))
                action = replace(action, brick=brick, pose=pose, velocity_W=scale(longer, action.velocity_W))
            case PushAction():
                impulse_W, offset_W = scale(factor**3 * longer, action.impulse_W), scale(factor, action.offset_W)
                action = replace(action, impulse_W=impulse_W, offset_W=offset_W)
            case MoveAction():
                places_W = tuple(scale(factor, place) for place in action.course.places_W)
                action = replace(action, course=HandCourse(places_W, longer * action.course.speed))
        return replace(action, time=longer * action.time)

    change = _same_names(scene, tuple(map(changed, scene.timeline.actions)), factor)
    larger = replace(change.scene.timeline, hold=longer * scene.timeline.hold)
    return replace(change, scene=replace(change.scene, timeline=larger))


def _box(brick: Brick, factor: float) -> Box:
    assert isinstance(brick.shape, Box)
    x, y, z = brick.shape.size
    return Box((factor * x, factor * y, factor * z))


def renamed(seed: int, scene: Scene) -> Change:
    """Return a scene whose bricks have other names, in another order of the alphabet."""
    old = [one.brick.id for one in scene.timeline.placements]
    numbers = list(range(len(old)))
    Random(seed).shuffle(numbers)
    names = {name: f"other {number:04}" for name, number in zip(old, numbers, strict=True)}

    def changed(action: Action) -> Action:
        match action:
            case Placement():
                return replace(action, brick=replace(action.brick, id=names[action.brick.id]))
            case PushAction() | MoveAction():
                return replace(action, brick=names[action.brick])
            case ReleaseAction():
                return replace(action, bricks=tuple(names[name] for name in action.bricks))
        return action

    actions = tuple(map(changed, scene.timeline.actions))
    timeline = replace(scene.timeline, actions=actions)
    return Change(Scene(timeline, names[scene.pushed]), names)


def reordered(seed: int, scene: Scene) -> Change:
    """Return a scene whose bricks are placed at the same time in another order."""
    first = [action for action in scene.timeline.actions if action.time == 0.0]
    later = [action for action in scene.timeline.actions if action.time > 0.0]
    Random(seed).shuffle(first)
    return _same_names(scene, (*first, *later))


def beside(far: float, scene: Scene) -> Change:
    """Return a scene with another tower at a distance [m], placed first."""
    other = [
        Placement(
            0.0,
            replace(one.brick, id=f"apart {one.brick.id}"),
            number // 2 + 1,
            _shifted(one.pose, (far, 0.7 * far, 0.0)),
        )
        for number, one in enumerate(four_stack(12))
    ]
    return _same_names(scene, (*other, *scene.timeline.actions))


CHANGES: Final[Mapping[str, Sequence[Callable[[Scene], Change]]]] = {
    "turn": [partial(turned, degrees) for degrees in (17.0, 45.0, 77.0, 90.0, 137.3, 180.0, 301.0)],
    "mirror": [partial(mirrored, axis) for axis in (0, 1)],
    "size": [partial(enlarged, factor) for factor in (0.25, 0.6, 4.0, 10.0)],
    "place": [partial(translated, by) for by in ((1.2345, -0.7654, 0.0), (-37.1, 12.3, 0.0))],
    "names": [partial(renamed, seed) for seed in (1, 2)],
    "order": [partial(reordered, seed) for seed in (1, 2)],
    "apart": [partial(beside, far) for far in (0.4, 3.0)],
}

# Comparison.


@dataclass(frozen=True, slots=True)
class Shifts:
    """Shifts of one run."""

    pushed: float  # [m]
    others: Mapping[BodyId, float]  # [m]
    fallen: int


def shifts(scene: Scene, system: System) -> Shifts:
    """Play a scene."""
    tracks = play(scene.timeline, system).tracks
    others = {name: one.shift for name, one in tracks.items() if name != scene.pushed}
    return Shifts(tracks[scene.pushed].shift, others, sum(one.state is BrickState.FALLEN for one in tracks.values()))


def compared(scene: Scene, system: System) -> dict[str, float]:
    """Return for each kind of change the largest changes of the shifts of the pushed plank and of another [%]."""
    base = shifts(scene, system)
    row = {"pushed_mm": 1000.0 * base.pushed, "fallen": float(base.fallen)}
    for kind, changes in CHANGES.items():
        row |= {f"{kind}_pushed_percent": 0.0, f"{kind}_other_percent": 0.0}
        for made in changes:
            change = made(scene)
            found = shifts(change.scene, system)
            for plank, percent in differences(base, change, found).items():
                key = f"{kind}_{plank}_percent"
                row[key] = max(row[key], percent)
    return row


def differences(base: Shifts, change: Change, found: Shifts) -> dict[str, float]:
    """Return how much the shift of the pushed plank changes, and of the other plank whose shift changes most [%]."""
    others = [
        abs(found.others[change.names[name]] / change.larger / shift - 1.0)
        for name, shift in base.others.items()
        if shift > NOTICED
    ]
    pushed = abs(found.pushed / change.larger / base.pushed - 1.0)
    return {"pushed": 100.0 * pushed, "other": 100.0 * max(others, default=0.0)}


def by_change(rows: Mapping[str, Mapping[str, Mapping[str, float]]]) -> dict[str, Row]:
    """Return for each kind of change the largest changes of all scenes, for each system."""
    return {
        kind: {
            f"{system}_{plank}_percent": max(row[f"{kind}_{plank}_percent"] for row in of.values())
            for system, of in rows.items()
            for plank in ("pushed", "other")
        }
        for kind in CHANGES
    }


def main() -> None:
    """Play and print the tables; write them on request."""
    arguments = parser(__doc__)
    arguments.add_argument("--systems", nargs="+", default=[*COMPARED], choices=[*COMPARED])
    arguments.add_argument("--scenes", nargs="+", default=[""], help="words of the names of scenes to play")
    chosen = arguments.parse_args()
    progress, console = Console(stderr=True, width=150), Console(width=170)
    asked = {name: made() for name, made in SCENES.items() if any(word in name for word in chosen.scenes)}
    runs: dict[str, dict[str, dict[str, float]]] = defaultdict(dict)
    for system, (name, scene) in track([*product(chosen.systems, asked.items())], "scenes", console=progress):
        row = runs[system][name] = compared(scene, COMPARED[system])
        progress.print(system, name, " ".join(f"{key} {value:.3g}" for key, value in row.items()))
    changes = by_change(runs)
    table = Table("changed", *next(iter(changes.values())))
    for name, found in changes.items():
        table.add_row(name, *(f"{value:.2f}" for value in found.values()))
    console.print(table)
    if chosen.write:
        record("invariance", "python -m benchmarks.invariance --write", {"changes": changes, **runs})


if __name__ == "__main__":
    main()
