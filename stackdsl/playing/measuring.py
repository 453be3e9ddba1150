"""All that is measured of a run by looks at what moves: places, energy, how a fall begins and where it ends."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from math import sqrt
from typing import TYPE_CHECKING

from stability.engines.scene_scale import USUAL_GRAVITY
from stability.mechanics.ground_motion import GroundMotion
from stability.model import BodyId, BodyState
from stability.statics.facts import Verdict
from stackdsl.playing.energy import EnergyMeter
from stackdsl.playing.landing import LandingWatch
from stackdsl.playing.motion_watch import MotionWatch
from stackdsl.playing.onset import OnsetWatch
from stackdsl.playing.overlap import OverlapMeter
from stackdsl.playing.passing import PassingWatch
from stackdsl.playing.sway import SwayMeter
from stackdsl.playing.watch import NOT_MOVING, Watch
from stackdsl.timeline import Placement, Timeline
from stackdsl.trace import Landing, Penetration, Sway

if TYPE_CHECKING:
    from stackdsl.recording.recorder import Recorder  # it brings numpy, which a run does without


@dataclass
class Measures:
    """What is told of one run."""

    timeline: Timeline
    watch: Watch = field(init=False)
    energy: EnergyMeter = field(init=False)
    onset: OnsetWatch = field(default_factory=OnsetWatch)
    motion: MotionWatch = field(init=False)
    passing: PassingWatch = field(init=False)
    _landing: LandingWatch = field(init=False)
    sway: SwayMeter | None = None  # None unless it is asked for
    overlap: OverlapMeter | None = None  # likewise
    recorder: "Recorder | None" = None  # likewise

    def __post_init__(self) -> None:
        gravity = self.timeline.world.gravity
        self.watch = Watch(not_moving=NOT_MOVING.scaled(lengths=1.0, times=sqrt(USUAL_GRAVITY / gravity)))
        self.passing = PassingWatch(self.watch)
        self.energy = EnergyMeter(gravity, self.timeline.world.planes[0])
        self.motion = MotionWatch(gravity)
        self._landing = LandingWatch(self.watch)
        if "sway" in self.timeline.measures:
            self.sway = SwayMeter(self.watch)
        if "penetration" in self.timeline.measures:
            self.overlap = OverlapMeter(self.timeline.world.planes)

    @property
    def swayed(self) -> Sway | None:
        """The largest swing, if it was asked for."""
        return self.sway.sway if self.sway is not None else None

    @property
    def overlapped(self) -> Penetration | None:
        """The deepest overlap, if it was asked for."""
        return self.overlap.penetration if self.overlap is not None else None

    @property
    def close(self) -> bool:
        """Whether to look more often than usual."""
        return self.onset.waiting or self._landing.falling

    def add(self, placement: Placement) -> None:
        """A brick has come."""
        self.watch.add(placement)
        self.motion.add(placement.brick)
        state = BodyState(placement.came or placement.pose, placement.velocity_W)
        self._see(placement.time, {placement.brick.id: state})
        if self.recorder is not None:
            self.recorder.add(placement.time, placement.brick, state)
        if self.overlap is not None:
            self.overlap.see(placement.time, self.watch.made_of, {placement.brick.id: state.pose})

    def remove(self, time: float, bricks: Iterable[BodyId]) -> None:
        """These were pulled out at a time [s]."""
        bricks = tuple(bricks)
        self.watch.remove(bricks)
        self.motion.stopped(bricks)
        self.energy.forget(bricks)
        if self.overlap is not None:
            self.overlap.forget(bricks)
        if self.recorder is not None:
            self.recorder.remove(time, bricks)

    def shaken(self, motion: GroundMotion) -> None:
        """The ground begins to shake."""
        self.energy.outside.motion = motion

    def saw(self, time: float, states: Mapping[BodyId, BodyState]) -> None:
        """Some of what may move is as told at a time [s]."""
        self._see(time, states)
        self._record(time, states)

    def acted(self, states: Mapping[BodyId, BodyState], verdict: Verdict | None) -> None:
        """Something was done, and judged; all that may move was seen as told."""
        self.energy.start()
        if verdict is not None and self.timeline.closely:
            self.onset.proven(verdict, self.watch.where(), self.timeline.world.planes, states)

    def judged(self, time: float, states: Mapping[BodyId, BodyState], frozen: Iterable[BodyId]) -> None:
        """These bricks move from now on, or did until now; what was frozen is not looked at any more."""
        frozen = tuple(frozen)
        self.watch.see(time, states)
        self._see(time, states)
        self._record(time, states)
        if self.overlap is not None:
            self.overlap.put(self.watch.made_of, {name: state.pose for name, state in states.items()})
        self.watch.freeze(frozen)
        self.motion.stopped(frozen)

    def weigh(self, time: float, states: Mapping[BodyId, BodyState], in_hands: bool) -> None:
        """Take in the energy of what moves of one part; `in_hands` if hands may be at work on it."""
        self.saw(time, states)
        self.energy.look(self.motion.see(time, states))
        if in_hands:
            self.energy.start(by_hand=True)  # it is told from what an engine adds only once they have let go

    def look(self, time: float, states: Mapping[BodyId, BodyState], everything: Mapping[BodyId, BodyState]) -> None:
        """Take in where that is which moves of one part, and all that does."""
        self.passing.see(time, states)
        self.watch.see(time, states)
        if self.sway is not None:
            self.sway.see(time, states)
        if self.overlap is not None:
            self.overlap.see(time, self.watch.made_of, {name: state.pose for name, state in states.items()})
        self.look_closely(time, everything)

    def look_closely(self, time: float, states: Mapping[BodyId, BodyState]) -> None:
        """The same between two looks. What has left its place is told by those alone, however closely one looks."""
        if self.timeline.closely:
            self.onset.see(states)
            self._landing.see(time, states)

    def landing(self, fallen: Collection[BodyId]) -> Landing | None:
        """Where these bricks came down."""
        return self._landing.landing(fallen)

    def _record(self, time: float, states: Mapping[BodyId, BodyState]) -> None:
        if self.recorder is not None:
            self.recorder.see(time, states)

    def _see(self, time: float, states: Mapping[BodyId, BodyState]) -> None:
        self.energy.see(time, self.watch.made_of, states)
