"""What a replay is told of a run, as JSON: names and texts are data, which the page takes for nothing else."""

from collections.abc import Mapping, Sequence
from math import isfinite
from typing import Any, TypeAlias

import numpy as np

from stability.model import BodyId, ConvexShape, Plane
from stackdsl.report.outcome_text import outcome_text
from stackdsl.report.weakest_text import weakest_json, weakest_text
from stackdsl.timeline import Arrival, Placement
from stackdsl.viewing.replay.packing import packed, packed_floats
from stackdsl.viewing.run_view import RunView
from stackdsl.viewing.shown_proofs import ShownProof

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
