"""Runs -> one self-contained HTML page that replays them."""

import base64
import hashlib
import json
import zlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from importlib.resources import files
from math import isfinite
from string import Template
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from stability.model import BodyId, ConvexShape, Plane
from stackdsl.report.statics import weakest_json, weakest_text
from stackdsl.report.text import outcome_text
from stackdsl.simulation.recording import NUMBER, ORIENTATION, POSITION, TIME, Recording
from stackdsl.timeline import Arrival, Placement
from stackdsl.viewing.run_view import RunView, ShownProof

# Poses over time in few bytes: rounded to what can be seen, told by how they change, and deflated.
#
# All that a brick does is told column by column (times, x, y, z, and the four parts of its orientation), as differences
# of differences of whole numbers: of what goes on as it did, these are zeros. `unpack.ts` reads it.


FINEST = 400.0  # the smallest side of all bricks in units of position: 0.02 mm of a plank of 7.8 mm
TURNS = 16_384.0  # a unit quaternion in units of orientation: 7 micrometres at the end of a plank of 120 mm
TICKS = 10_000.0  # a second in units of time


@dataclass(frozen=True, slots=True)
class Packed:
    """The poses of a recording."""

    counts: tuple[int, ...]  # of each brick
    origin: tuple[float, float, float]  # of the whole numbers [m]
    unit: float  # of a position [m]
    data: str  # base64 of deflated bytes


def packed(recording: Recording) -> Packed:
    """All poses of a recording."""
    rows = recording.keys
    numbers = rows[:, NUMBER].astype(int)
    smallest = min((brick.shape.least_thickness for brick in recording.bricks), default=1.0)
    origin = np.round(rows[:, POSITION].mean(axis=0), 6) if len(rows) else np.zeros(3)
    away = float(np.abs(rows[:, POSITION] - origin).max(initial=0.0))
    unit = max(smallest / FINEST, away / 2.0**30)
    whole = np.hstack(
        (
            np.round(rows[:, TIME : TIME + 1] * TICKS),
            np.round((rows[:, POSITION] - origin) / unit),
            np.round(_continuous(rows[:, ORIENTATION], numbers) * TURNS),
        )
    ).astype(np.int64)
    first = np.concatenate(([True], numbers[1:] != numbers[:-1])) if len(rows) else np.empty(0, bool)
    changes = _changes(_changes(whole, first), first).astype(np.int32)
    counts = np.bincount(numbers, minlength=len(recording.bricks)) if len(rows) else np.empty(0, int)
    return Packed(tuple(counts.tolist()), tuple(origin.tolist()), unit, deflated(_planes(changes.T)))


def packed_floats(values: NDArray[np.float64]) -> str:
    """Numbers with the seven digits of a 32-bit float, as base64 of deflated bytes."""
    return deflated(_planes(values.astype("<f4").view("<i4")))


def deflated(data: bytes) -> str:
    """Bytes as base64 of what zlib makes of them."""
    return base64.b64encode(zlib.compress(data, 9)).decode("ascii")


def _changes(whole: NDArray[np.int64], first: NDArray[np.bool_]) -> NDArray[np.int64]:
    """What is added to each row from the one before; the first of each brick as it is."""
    before = np.vstack((np.zeros_like(whole[:1]), whole[:-1]))
    return whole - np.where(first[:, None], 0, before)


def _planes(whole: NDArray[np.int32]) -> bytes:
    """The lowest bytes of all numbers, then the next ones, and so on: small numbers leave the latter empty."""
    return np.ascontiguousarray(whole.astype("<i4").reshape(-1, 1).view(np.uint8).reshape(-1, 4).T).tobytes()


def _continuous(orientations: NDArray[np.float64], numbers: NDArray[np.intp]) -> NDArray[np.float64]:
    """The same turns, each brick's quaternions with the signs that make them change least."""
    if not len(orientations):
        return orientations
    flips = np.where((orientations[1:] * orientations[:-1]).sum(axis=1) < 0.0, -1.0, 1.0)
    flips[numbers[1:] != numbers[:-1]] = 1.0
    signs = np.concatenate(([1.0], np.cumprod(flips)))
    starts = signs[np.searchsorted(numbers, numbers)]
    steady: NDArray[np.float64] = orientations * (signs * starts)[:, None]
    return steady


# What a replay is told of a run, as JSON: names and texts are data, which the page takes for nothing else.


Json: TypeAlias = Mapping[str, Any]


def payload_of(run: RunView, hurried: bool = False) -> Json:
    """One run; who is in a hurry hears of its weakest spot later."""
    placements = {placement.brick.id: placement for placement in run.timeline.placements}
    bricks = [placements[brick.id] for brick in run.recording.bricks]
    numbers = {placement.brick.id: number for number, placement in enumerate(bricks)}
    shapes = list(dict.fromkeys(placement.brick.shape for placement in bricks))
    poses = packed(run.recording)
    return {
        "name": run.name,
        "system": run.system,
        "description": run.description,
        "verdict": run.verdict,
        "end": run.trace.cost.simulated_time,
        "outcomes": _outcomes(run),
        "planes": [_plane(plane) for plane in run.timeline.world.planes],
        "shapes": [_shape(shape) for shape in shapes],
        "bricks": _bricks(run, bricks, shapes),
        "poses": {"counts": poses.counts, "origin": poses.origin, "unit": poses.unit, "data": poses.data},
        "events": _events(run, numbers),
        "proofs": [_proof(proof, numbers) for proof in run.proofs.standing],
        "fall": _fall(run, numbers),
        "room": _room(run, numbers),
        "weakest": None if hurried else _weakest(run, numbers),
        "marks": run.marks,
    }


def _outcomes(run: RunView) -> list[Json]:
    return [
        {"passed": outcome.passed, "text": f"{outcome.span}: {outcome_text(outcome)}"}
        for outcome in run.result.outcomes
    ]


def _plane(plane: Plane) -> Json:
    return {"name": plane.id, "point": plane.point_W, "normal": plane.normal_W}


def _shape(shape: ConvexShape) -> Json:
    return {"corners": [list(corner) for corner in shape.corners], "faces": [face.corners for face in shape.faces]}


def _bricks(run: RunView, placements: Sequence[Placement], shapes: Sequence[ConvexShape]) -> Json:
    """By column: a structure of ten thousand bricks says each key once."""
    numbers = {shape: number for number, shape in enumerate(shapes)}
    tracks = run.trace.tracks
    return {
        "name": [placement.brick.id for placement in placements],
        "shape": [numbers[placement.brick.shape] for placement in placements],
        "level": [placement.level for placement in placements],
        "grams": [float(f"{1000.0 * placement.brick.mass:.4g}") for placement in placements],
        "density": [float(f"{placement.brick.mass / placement.brick.shape.volume:.3g}") for placement in placements],
        "thrown": [int(placement.arrival in (Arrival.THROWN, Arrival.DROPPED)) for placement in placements],
        "gone": [_finite(gone) for gone in run.recording.gone.tolist()],
        "left": [tracks[placement.brick.id].left_at for placement in placements],
        "place": [str(run.places[placement.brick.id]) for placement in placements],
    }


def _events(run: RunView, numbers: Mapping[BodyId, int]) -> list[Json]:
    """What happened, and when what was thrown or dropped arrives."""
    told = [
        {
            "time": round(event.time, 6),
            "kind": event.kind.value,
            "bricks": [numbers[brick] for brick in event.bricks if brick in numbers],
            "riding": [numbers[brick] for brick in event.riding if brick in numbers],
            "reason": event.reason,
        }
        for event in run.trace.events
    ]
    told += [
        {
            "time": round(placement.time + placement.flight, 6),
            "kind": "hit",
            "bricks": [numbers[placement.brick.id]],
            "riding": [],
            "reason": f"{placement.brick.id} {placement.arrival}",
        }
        for placement in run.timeline.placements
        if placement.hits and placement.brick.id in numbers
    ]
    return sorted(told, key=lambda event: event["time"])


def _proof(proof: ShownProof, numbers: Mapping[BodyId, int]) -> Json:
    contacts = proof.contacts
    points = np.array([point for contact in contacts for point in contact.points_W]).reshape(-1, 3)
    forces = np.array([force for contact in contacts for force in contact.forces_W]).reshape(-1, 3)
    stages = list(dict.fromkeys(brick.stage for brick in proof.bricks.values()))
    known = {name: brick for name, brick in proof.bricks.items() if name in numbers}
    return {
        "begin": proof.begin,
        "end": _finite(proof.end),
        "stages": stages,
        "bricks": [numbers[name] for name in known],
        "stage": [stages.index(brick.stage) for brick in known.values()],
        "depth": [None if b.depth is None else float(f"{1000.0 * b.depth:.4g}") for b in known.values()],
        "rests": [
            [[numbers.get(below, below), _finite(round(share, 4))] for below, share in brick.rests_on.items()]
            for brick in known.values()
        ],
        "lower": [numbers.get(contact.lower, contact.lower) for contact in contacts],
        "upper": [numbers.get(contact.upper, contact.upper) for contact in contacts],
        "counts": [len(contact.points_W) for contact in contacts],
        "points": packed_floats(points),
        "forces": packed_floats(forces),
    }


def _fall(run: RunView, numbers: Mapping[BodyId, int]) -> Json | None:
    fall = run.proofs.fall
    if fall is None:
        return None
    moving = {name: motion for name, motion in fall.motion.velocity.items() if name in numbers}
    return {
        "time": fall.time,
        "reason": fall.reason,
        "bricks": [numbers[name] for name in moving],
        "velocity": [list(velocity) for velocity, _ in moving.values()],
        "spin": [list(spin) for _, spin in moving.values()],
    }


def _room(run: RunView, numbers: Mapping[BodyId, int]) -> Json | None:
    name, depth = run.least_room or ("", 0.0)
    return {"brick": numbers[name], "depth": float(f"{1000.0 * depth:.4g}")} if name in numbers else None


def _weakest(run: RunView, numbers: Mapping[BodyId, int]) -> Json | None:
    weakest = run.weakest()
    if weakest is None or weakest.brick not in numbers:
        return None
    return {**weakest_json(weakest), "text": weakest_text(weakest)}


def _finite(value: float) -> float | None:
    """JSON has no number that is not finite."""
    return value if isfinite(value) else None


# Runs -> one HTML page. It holds its program, its style and its data, and is allowed to ask for nothing else.
#
# What comes from a scenario is data: it stands in a script of JSON, in which `<` is written as an escape, and the
# program puts it on the page as text. The policy in the head lets nothing run but the two programs whose hashes it
# names.


# Inflates the program and lets it run: it is four times as long as that.
LOADER: Final = (
    "(async()=>{const b=Uint8Array.from(atob(document.getElementById('program').textContent),c=>c.charCodeAt(0));"
    "const s=document.createElement('script');"
    "s.textContent=await new Response(new Blob([b]).stream().pipeThrough(new DecompressionStream('deflate'))).text();"
    "document.body.append(s)})()"
)
LIVE_POLICY: Final = "; connect-src 'self'"


def replay_page(runs: Sequence[RunView], title: str) -> str:
    """The page that plays these runs, two of them side by side if that is wanted."""
    return page_of([told(run) for run in runs], title)


def live_page(title: str) -> str:
    """A page that hears of its runs from where it was loaded, and of each again whenever it has changed."""
    return page_of([], title, live=True)


def told(run: RunView, hurried: bool = False) -> str:
    """What a page is told of a run, as JSON in one line; see `payload_of`."""
    return json.dumps(payload_of(run, hurried), separators=(",", ":"), allow_nan=False)


def page_of(runs: Sequence[str], title: str, live: bool = False) -> str:
    """The page of runs that are `told`."""
    program, style = program_and_style()
    return Template(_packaged("replay.html")).substitute(
        title=escape(title),
        policy=policy_of((LOADER, program), (style,)) + (LIVE_POLICY if live else ""),
        live=" data-live" if live else "",
        style=style,
        licence=_packaged("replay.LICENSE.txt"),
        program=deflated(program.encode()),
        loader=LOADER,
        data=harmless(f"[{','.join(runs)}]"),
    )


def harmless(data: str) -> str:
    """JSON that ends no script and begins no comment of HTML, whatever texts are in it."""
    return data.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _packaged(name: str) -> str:
    return files("stackdsl.viewing.replay").joinpath(name).read_text(encoding="utf-8")


def program_and_style() -> tuple[str, str]:
    """What every page that plays runs is made of, beside the LOADER."""
    return _packaged("replay.js"), _packaged("replay.css")


def policy_of(scripts: Iterable[str], styles: Iterable[str]) -> str:
    """The content security policy by which these scripts run and these styles hold, and nothing else does."""
    run, hold = (" ".join(map(hash_of, texts)) for texts in (scripts, styles))
    return f"default-src 'none'; script-src {run}; style-src {hold}; base-uri 'none'; form-action 'none'"


def hash_of(text: str) -> str:
    """How a content security policy names a script or a style that stands in the page."""
    digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode("ascii")
    return f"'sha256-{digest}'"
