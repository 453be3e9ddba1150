"""Trace -> observations: what a person would note of a run, and what of it another run of the same scene changes."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import degrees, isfinite
from typing import TypeAlias

from stability.shapes.in_pose import top_W
from stackdsl.trace import NO_PART, STAND, BrickState, Trace
from stackdsl.wording import MILLIMETRES

Seen: TypeAlias = float | str | tuple[str, ...] | None  # None where there was nothing of the kind to see

PERCENT = 100.0
MOST_RELATIVE = 0.05  # what is large, such as how far debris flies, may change by this share of itself


@dataclass(frozen=True, slots=True)
class Kind:
    """One kind of observation, and by how much it may change until it counts as moved."""

    unit: str = ""  # of numbers
    tolerance: float = 0.0  # in `unit`


KINDS: Mapping[str, Kind] = {
    "verdict": Kind(),
    "collapse level": Kind("levels"),
    "collapse time": Kind("s", 0.05),  # as in golden files
    "first to leave": Kind(),
    "fallen": Kind(),
    "drift": Kind("mm", 0.1),  # of the whole structure, what fell included, as everywhere else
    "drift of what stands": Kind("mm", 0.1),  # in the end; beside what fell, creep would hide
    "shift before": Kind("mm", 0.1),  # the same when a brick was last set down before a collapse, or at all
    "largest tilt": Kind("deg", 0.5),
    "height": Kind("mm", 0.5),  # as in golden files
    "energy gain": Kind("%", 0.1),
    "reach": Kind("mm", 1.0),
    "bearing": Kind("deg", 1.0),
}


@dataclass(frozen=True, slots=True)
class Change:
    """One observation of a run, and the same of the run that it is held against."""

    name: str  # a key of KINDS
    before: Seen
    after: Seen

    @property
    def unit(self) -> str:
        """Of both, where they are numbers."""
        return KINDS[self.name].unit

    @property
    def difference(self) -> float | None:
        """How much larger the second is; None unless both are numbers."""
        if isinstance(self.before, float) and isinstance(self.after, float):
            return turned_back(self.after - self.before) if self.name == "bearing" else self.after - self.before
        return None

    @property
    def moved(self) -> bool:
        """Whether they differ by more than the tolerance of their kind, or in anything that is no number."""
        if self.difference is None or not isinstance(self.before, float) or not isinstance(self.after, float):
            return self.before != self.after
        size = 0.0 if self.unit in ("levels", "deg") else max(abs(self.before), abs(self.after))
        return abs(self.difference) > max(KINDS[self.name].tolerance, MOST_RELATIVE * size)


def turned_back(angle: float) -> float:
    """An angle [deg] between -180 and 180."""
    return (angle + 180.0) % 360.0 - 180.0


def observations(trace: Trace) -> Mapping[str, Seen]:
    """All kinds, in the order of KINDS."""
    structure = [track for track in trace.tracks.values() if track.state not in NO_PART]
    placed = [track for track in structure if track.state is not BrickState.UNPLACED]
    standing = [track for track in placed if track.state in STAND]
    collapse, landing = trace.collapse, trace.landing
    seen: dict[str, Seen] = {
        "verdict": trace.reported_verdict,
        "collapse level": float(collapse.level) if collapse is not None else None,
        "collapse time": collapse.time if collapse is not None else None,
        "first to leave": collapse.brick if collapse is not None else None,
        "fallen": tuple(sorted(track.brick.id for track in placed if track.state is BrickState.FALLEN)),
        "drift": MILLIMETRES * trace.drift,
        "drift of what stands": MILLIMETRES * max((track.shift for track in standing), default=0.0),
        "shift before": MILLIMETRES * trace.shift_before,
        "largest tilt": degrees(max((track.tilt for track in placed), default=0.0)),
        "height": MILLIMETRES * max((top_W(track.brick.shape, track.final) for track in standing), default=0.0),
        "energy gain": _finite(PERCENT * trace.energy.gain) if trace.energy is not None else None,
        "reach": MILLIMETRES * landing.reach if landing is not None else None,
        "bearing": degrees(landing.bearing) if landing is not None else None,
    }
    return {name: seen[name] for name in KINDS}


def _finite(value: float) -> float | None:
    return value if isfinite(value) else None


def changes(before: Mapping[str, Seen], after: Mapping[str, Seen]) -> tuple[Change, ...]:
    """Every kind that either run has seen, observation by observation."""
    pairs = ((name, before.get(name), after.get(name)) for name in KINDS)
    return tuple(Change(*pair) for pair in pairs if pair[1:] != (None, None))
