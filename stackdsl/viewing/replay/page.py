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

from stability.analysis.weakest import Weakest
from stability.geometry.round_solid import RoundSolid
from stability.model import BodyId, ConvexShape, Plane
from stability.ties import Tie
from stackdsl.checking.failure_cause import ARRIVALS
from stackdsl.report.statics import weakest_json
from stackdsl.simulation.recording import NUMBER, ORIENTATION, POSITION, TIME, Recording
from stackdsl.timeline import Arrival, Placement
from stackdsl.trace import EventKind, RunVerdict
from stackdsl.viewing.bores import surface_of_pipe
from stackdsl.viewing.drawing import VIEWS
from stackdsl.viewing.pictures import heading_at, panels_at, picture
from stackdsl.viewing.replay.verdict_band import verdict_json
from stackdsl.viewing.run_view import RunView, ShownProof
from stackdsl.viewing.studs import pitches, studs_of
from stackdsl.viewing.style import icon, icon_sprite, shared_style
from stackdsl.viewing.svg import dark_rules
from stackdsl.wording import weakest_text

# Compact poses over time: rounded to visible accuracy, delta-encoded, and deflated.
#
# The poses of a brick are stored by column (time, x, y, z, and the four parts of its orientation), as second
# differences of integers, which are zero for a steady motion. `unpack.ts` reads them.


FINEST = 400.0  # units of position per smallest side of all bricks: 0.02 mm for a plank of 7.8 mm
TURNS = 16_384.0  # units of orientation per unit quaternion: 7 micrometres at the end of a plank of 120 mm
TICKS = 10_000.0  # units of time per second


@dataclass(frozen=True, slots=True)
class PackedPoses:
    """The packed poses of a recording."""

    counts: tuple[int, ...]  # number of poses, by brick
    origin: tuple[float, float, float]  # of positions [m]
    unit: float  # of positions [m]
    data: str  # base64 of deflated bytes


def packed(recording: Recording) -> PackedPoses:
    """Pack all poses of a recording."""
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
    return PackedPoses(tuple(counts.tolist()), tuple(origin.tolist()), unit, deflated(_planes(changes.T)))


def packed_floats(values: NDArray[np.float64]) -> str:
    """Pack numbers as 32-bit floats: base64 of deflated bytes."""
    return deflated(_planes(values.astype("<f4").view("<i4")))


def deflated(data: bytes) -> str:
    """Return the base64 of bytes deflated by zlib."""
    return base64.b64encode(zlib.compress(data, 9)).decode("ascii")


def _changes(whole: NDArray[np.int64], first: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return the difference of each row from the one before; the first row of each brick is kept."""
    before = np.vstack((np.zeros_like(whole[:1]), whole[:-1]))
    return whole - np.where(first[:, None], 0, before)


def _planes(whole: NDArray[np.int32]) -> bytes:
    """Return the lowest bytes of all numbers, then the next, and so on; they compress well, as most are zero."""
    return np.ascontiguousarray(whole.astype("<i4").reshape(-1, 1).view(np.uint8).reshape(-1, 4).T).tobytes()


def _continuous(orientations: NDArray[np.float64], numbers: NDArray[np.intp]) -> NDArray[np.float64]:
    """Return the orientations with signs that make the quaternions of each brick continuous."""
    if not len(orientations):
        return orientations
    flips = np.where((orientations[1:] * orientations[:-1]).sum(axis=1) < 0.0, -1.0, 1.0)
    flips[numbers[1:] != numbers[:-1]] = 1.0
    signs = np.concatenate(([1.0], np.cumprod(flips)))
    starts = signs[np.searchsorted(numbers, numbers)]
    steady: NDArray[np.float64] = orientations * (signs * starts)[:, None]
    return steady


# The data of a replay as JSON; the page treats names and texts as data only.


Json: TypeAlias = Mapping[str, Any]


def payload_of(run: RunView, hurried: bool = False) -> Json:
    """Return the data of one run; `hurried` omits the weakest mechanism, which takes seconds."""
    placements = {placement.brick.id: placement for placement in run.timeline.placements}
    bricks = [placements[brick.id] for brick in run.recording.bricks]
    numbers = {placement.brick.id: number for number, placement in enumerate(bricks)}
    pitch = pitches(run.timeline.world.joints)
    drawn = [(placement.brick.shape, pitch.get(placement.brick.id)) for placement in bricks]
    shapes = list(dict.fromkeys(drawn))
    numbers_of = {shape: number for number, shape in enumerate(shapes)}
    poses = packed(run.recording)
    return {
        "name": run.name,
        "system": run.system,
        "description": run.description,
        "verdict": run.verdict,
        "end": run.trace.cost.simulated_time,
        "told": verdict_json(run, hurried),
        "gravity": run.timeline.world.gravity,
        "planes": [_plane(plane) for plane in run.timeline.world.planes],
        "shapes": [_shape(*shape) for shape in shapes],
        "bricks": {**_bricks(run, bricks), "shape": [numbers_of[shape] for shape in drawn]},
        "poses": {"counts": poses.counts, "origin": poses.origin, "unit": poses.unit, "data": poses.data},
        "events": _events(run, numbers),
        "proofs": [_proof(proof, numbers) for proof in run.proofs.standing],
        "fall": _fall(run, numbers),
        "room": _room(run, numbers),
        "weakest": None if hurried else weakest_told(run.weakest()),
        "limit": None if hurried else _limit(run, numbers),
        "strength": None if hurried else _strength(run, numbers),
        "marks": run.marks,
        "ties": [_tie(tie, numbers) for tie in run.timeline.world.ties],
    }


def _tie(tie: Tie, numbers: Mapping[BodyId, int]) -> Json:
    """Return the bricks of a tie, and its corners in order, the first one again if it is closed [m]."""
    bricks = sorted(numbers[name] for name in tie.around)
    return {"bricks": bricks, "points": [[_short(part) for part in point] for point in tie.course_W]}


def _plane(plane: Plane) -> Json:
    return {"name": plane.id, "point": plane.point_W, "normal": plane.normal_W}


def _shape(shape: ConvexShape, pitch: float | None) -> Json:
    """Return the corners and faces of a shape, with its bore, and with its studs if these have a pitch [m]."""
    if isinstance(shape, RoundSolid) and shape.bore:
        points, loops = surface_of_pipe(shape)
        return {"corners": [list(point) for point in points], "faces": loops, "curved": list(range(len(loops)))}
    corners, faces = [*shape.corners], [face.corners for face in shape.faces]
    for foot, top in studs_of(shape, pitch):
        begin, count = len(corners), len(foot)
        corners += [*foot, *top]
        faces.append(tuple(range(begin + count, begin + 2 * count)))
        for side in range(count):
            after = (side + 1) % count
            faces.append((begin + side, begin + after, begin + count + after, begin + count + side))
    drawn: dict[str, Any] = {"corners": [list(corner) for corner in corners], "faces": faces}
    if isinstance(shape, RoundSolid):
        drawn["curved"] = [number for number, face in enumerate(shape.faces) if face not in shape.flat_faces]
    return drawn


def _bricks(run: RunView, placements: Sequence[Placement]) -> Json:
    """Return the bricks by column, so that each key occurs once for any number of bricks."""
    tracks = run.trace.tracks
    return {
        "name": [placement.brick.id for placement in placements],
        "level": [placement.level for placement in placements],
        "grams": [float(f"{1000.0 * placement.brick.mass:.4g}") for placement in placements],
        "density": [float(f"{placement.brick.mass / placement.brick.shape.volume:.3g}") for placement in placements],
        "thrown": [int(placement.arrival in (Arrival.THROWN, Arrival.DROPPED)) for placement in placements],
        "gone": [_finite(gone) for gone in run.recording.removed_at.tolist()],
        "left": [tracks[placement.brick.id].left_at for placement in placements],
        "place": [str(run.places[placement.brick.id]) for placement in placements],
    }


def _events(run: RunView, numbers: Mapping[BodyId, int]) -> list[Json]:
    """Return the events; the reason of an arrival is its kind in words."""
    arrivals = {placement.brick.id: placement.arrival for placement in run.timeline.placements}
    events = [
        {
            "time": round(event.time, 6),
            "kind": event.kind.value,
            "bricks": [numbers[brick] for brick in event.bricks if brick in numbers],
            "riding": [numbers[brick] for brick in event.riding if brick in numbers],
            "reason": ARRIVALS[arrivals[event.bricks[0]]] if event.kind is EventKind.PLACED else event.reason,
        }
        for whole in run.trace.events
        for event in whole.parts
    ]
    return sorted(events, key=lambda event: event["time"])


def _proof(proof: ShownProof, numbers: Mapping[BodyId, int]) -> Json:
    contacts = proof.contacts
    points = np.array([point for contact in contacts for point in contact.points_W]).reshape(-1, 3)
    forces = np.array([force for contact in contacts for force in contact.forces_W]).reshape(-1, 3)
    stages, thrust = list(dict.fromkeys(brick.stage for brick in proof.bricks.values())), proof.thrust
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
        "loads": [
            [numbers[load.brick], *map(_short, load.point_W), *map(_short, load.force_W)]
            for load in proof.loads
            if load.brick in numbers and any(load.force_W)
        ],
        "thrust": [
            [numbers[line.brick], *map(_short, (*line.begin_W, *line.end_W)), _short(line.force)]
            for line in thrust.lines
            if line.brick in numbers
        ],
        "hinges": [[numbers[brick], *map(_short, point)] for brick, point in thrust.hinges if brick in numbers],
    }


def _short(value: float) -> float:
    return float(f"{value:.6g}") + 0.0


def _fall(run: RunView, numbers: Mapping[BodyId, int]) -> Json | None:
    fall = run.proofs.fall
    if fall is None:
        return None
    moving = {name: motion for name, motion in fall.motion.velocity.items() if name in numbers}
    return {
        "time": fall.time,
        "reason": fall.reason,
        "predicted": run.trace.verdict is RunVerdict.STANDS,
        "bricks": [numbers[name] for name in moving],
        "velocity": [list(velocity) for velocity, _ in moving.values()],
        "spin": [list(spin) for _, spin in moving.values()],
    }


def _room(run: RunView, numbers: Mapping[BodyId, int]) -> Json | None:
    name, depth = run.least_room or ("", 0.0)
    return {"brick": numbers[name], "depth": float(f"{1000.0 * depth:.4g}")} if name in numbers else None


def _limit(run: RunView, numbers: Mapping[BodyId, int]) -> Json | None:
    found = run.limit
    if found is None:
        return None
    return {
        "factor": float(f"{found.factor:.4g}"),
        "text": found.gives_way,
        "bricks": [numbers[name] for name in found.moving],
        "lower": [numbers.get(joint.lower, joint.lower) for joint in found.joints],
        "upper": [numbers.get(joint.upper, joint.upper) for joint in found.joints],
        "used": [round(joint.used, 4) for joint in found.joints],
        "yields": [int(joint.yields) for joint in found.joints],
        "points": [[[round(part, 6) for part in point] for point in joint.points_W] for joint in found.joints],
    }


def _strength(run: RunView, numbers: Mapping[BodyId, int]) -> Json | None:
    used = {name: share for name, share in run.used_strength.items() if name in numbers}
    crushing = run.trace.crushing
    return (
        {
            "bricks": [numbers[name] for name in used],
            "used": [float(f"{share:.6g}") for share in used.values()],
            "crushes": None if crushing is None else numbers.get(crushing.brick),
        }
        if used
        else None
    )


def weakest_told(weakest: Weakest | None) -> Json | None:
    """Return the weakest brick of a run for a page, with its motion in words; None if there is none."""
    return None if weakest is None else {**weakest_json(weakest), "text": weakest_text(weakest)}


def _finite(value: float) -> float | None:
    """Return a finite number, or None, as JSON has no infinity."""
    return value if isfinite(value) else None


# Runs -> one HTML page, with its program, its style and its data; it may load nothing else.
#
# Everything from a scenario is data: it is in a script of JSON, in which `<` is escaped, and the program shows it as
# text. The policy in the head allows only the two programs whose hashes it contains.


# Inflates the program, which is four times as long, and runs it.
LOADER: Final = (
    "(async()=>{const b=Uint8Array.from(atob(document.getElementById('program').textContent),c=>c.charCodeAt(0));"
    "const s=document.createElement('script');"
    "s.textContent=await new Response(new Blob([b]).stream().pipeThrough(new DecompressionStream('deflate'))).text();"
    "document.body.append(s)})()"
)
LIVE_POLICY: Final = "; connect-src 'self'"


# Within a notebook, which tells the verdict above the page, the band keeps only the remedy and the details.
FRAMED: Final = """
.band h1, .band .image, .band .who, .band .lead > span:not(.help) { display: none; }
.band .words { display: flex; flex-wrap: wrap; gap: 4px 16px; align-items: baseline; }
"""


def replay_page(runs: Sequence[RunView], title: str, framed: bool = False) -> str:
    """Return the page that replays these runs; it can show two of them side by side.

    A `framed` page does not tell the verdict, since the page around it does.
    """
    shown = [shown_run(run) for run in runs]
    return page_of([run.json for run in shown], title, stills=[run.still for run in shown], framed=framed)


def live_page(title: str) -> str:
    """Return a page that receives its runs and their changes from its server."""
    return page_of([], title, live=True)


@dataclass(frozen=True, slots=True)
class ShownRun:
    """The content of a page for one run."""

    json: str  # one line
    still: str  # HTML for browsers without JavaScript, and a drawing for those without WebGL


def shown_run(run: RunView) -> ShownRun:
    """Return the data of a run, and what shows it without the program of the page."""
    payload = payload_of(run)
    return ShownRun(_line_of(payload), still_html(run, payload["told"]))


def run_json(run: RunView, hurried: bool = False) -> str:
    """Return the data of a run as one line of JSON; see `payload_of`."""
    return _line_of(payload_of(run, hurried))


def _line_of(payload: Json) -> str:
    return json.dumps(payload, separators=(",", ":"), allow_nan=False)


def page_of(
    runs: Sequence[str], title: str, live: bool = False, stills: Sequence[str] = (), framed: bool = False
) -> str:
    """Return the page of runs, each given as `run_json`, with what shows them without the program."""
    program, style = program_and_style()
    style += FRAMED * framed
    return Template(_packaged("replay.html")).substitute(
        title=escape(title),
        policy=policy_of((LOADER, program), (style, dark_rules())) + (LIVE_POLICY if live else ""),
        live=" data-live" if live else "",
        style=style,
        icons=icon_sprite(),
        stills="\n".join(stills),
        licence=_packaged("replay.LICENSE.txt"),
        program=deflated(program.encode()),
        loader=LOADER,
        data=harmless(f"[{','.join(runs)}]"),
    )


# The page without JavaScript: the verdict in words, and a drawing of the end. The program shows the same drawing where
# the browser has no WebGL.


MOST_DRAWN: Final = 200  # bricks of a drawing, which takes 0.3 kB and a millisecond for each
SHAPES: Final = {"open": "skipped"}  # icons of the statuses that have none of their name


def still_html(run: RunView, told: Json) -> str:
    """Return the verdict of a run and a drawing of its end as HTML; of many bricks, without the drawing."""
    status: str = told["status"]
    drawing = ""
    if run.marks is None and len(run.recording.bricks) <= MOST_DRAWN:
        end = run.trace.cost.simulated_time
        drawing = picture(run, heading_at(run, end), panels_at([VIEWS["three-quarter"]], end))
    lead = "<br>".join(f"<b>{escape(name)}</b> {escape(text)}" for name, text in told["facts"])
    return (
        f'<section class="still" data-run="{escape(run.name)}"><header class="band" data-status="{status}">'
        f'<span class="image">{icon(SHAPES.get(status, status))}</span>'
        f'<div class="words"><h1>{escape(told["headline"])}</h1><p class="lead">{lead}</p></div>'
        f'<div class="who"><b>{escape(run.name)}</b><span>{escape(run.system)}</span></div></header>'
        f"{_claims_table(told['claims'])}<figure>{drawing}</figure></section>"
    )


def _claims_table(claims: Sequence[Json]) -> str:
    keys = {"name": "claim", "expected": "expected", "measured": "measured", "place": "written at"}
    heads = "".join(f"<th>{head}</th>" for head in ("", *keys.values()))
    rows = []
    for claim in claims:
        image, word = ("passed", "holds") if claim["passed"] else ("failed", "fails")
        cells = "".join(f'<td data-name="{head}">{escape(claim[key])}</td>' for key, head in keys.items())
        rows.append(f'<tr><td class="{image}">{icon(image)}{word}</td>{cells}</tr>')
    return f"<table><thead><tr>{heads}</tr></thead><tbody>{''.join(rows)}</tbody></table>" if rows else ""


def harmless(data: str) -> str:
    """Escape JSON so that no text in it can end a script or begin a comment of HTML."""
    return data.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _packaged(name: str) -> str:
    return files("stackdsl.viewing.replay").joinpath(name).read_text(encoding="utf-8")


def program_and_style() -> tuple[str, str]:
    """Return the program and the style of a page of replays; it also needs the LOADER."""
    return _packaged("replay.js"), shared_style() + _packaged("replay.css")


def policy_of(scripts: Iterable[str], styles: Iterable[str]) -> str:
    """Return the content security policy that allows only these scripts and styles."""
    run, hold = (" ".join(map(hash_of, texts)) for texts in (scripts, styles))
    return f"default-src 'none'; script-src {run}; style-src {hold}; base-uri 'none'; form-action 'none'"


def hash_of(text: str) -> str:
    """Return the hash of an inline script or style, as in a content security policy."""
    digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode("ascii")
    return f"'sha256-{digest}'"
