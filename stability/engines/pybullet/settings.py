"""All settings of PyBullet that change what comes out, in one value; no engine is needed to say so."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import ClassVar, Self

from stability.engines.protocol import EngineSettings, Package
from stability.engines.scene_scale import SAMPLING, USUAL_GRAVITY, SceneScale, power_of_two


@dataclass(frozen=True, kw_only=True)
class PyBulletSettings(EngineSettings):
    """How PyBullet steps; `scale` is applied inside the adapter."""

    package: ClassVar[Package] = Package("pybullet", "pip install pybullet, with Python 3.11, for which it has wheels")
    world: ClassVar[str] = "stability.engines.pybullet.world:PyBulletWorld"

    iterations: int  # of the contact solver, per step
    contact_erp: float  # share of a contact's overlap that one step takes back
    # Contacts further apart than this share of half the diagonal of a brick are dropped. (PyBullet makes the threshold
    # that it is told relative to the size of a shape.)
    breaking_threshold: float
    # Froude scaling: the engine sees lengths x scale and times x sqrt(scale), which leaves gravity and physics as they
    # are and lifts small bricks clear of the solver's absolute thresholds.
    scale: float = 1.0
    # Shares of a velocity lost in a second of the engine, which is 1 / sqrt(scale) of a second of the scene. PyBullet
    # takes 1 + velocity times as much, in its own units.
    linear_damping: float = 0.0
    angular_damping: float = 0.0
    residual_threshold: float = 0.0  # the solver stops early below this; 0 makes it use all its iterations
    friction_anchor: bool = False  # springs in the contact plane that hold resting contacts in place
    friction_erp: float = 0.2  # share of the slip of such a contact that one step takes back
    contact_slop: float = 1e-5  # [engine m] overlap that is let be
    # Bricks get edges rounded by this share of their smallest side, within their outer size, so that what touches along
    # an edge is pushed in the right direction; 0 leaves them sharp, and edges are then taken for faces.
    edge_rounding: float = 0.0
    # What touches along an edge is found anew as soon as that has slid so far that its normal is another.
    fresh_edges: bool = False
    # Bricks with rounded edges meet planes as half-spaces while all is slow, and not as large boxes.
    half_spaces: bool = False
    # Bricks with rounded edges sink by this share of their smallest side under their own weight, so that all points
    # that touch carry their share, though one a step is found; 0 makes contacts hard.
    sinking: float = 0.0
    # What leans at rest is held by no more friction than Coulomb's cone allows, not by a pyramid about it.
    friction_cones: bool = False
    # Bodies by themselves, not as roots of trees of links: another solver, whose friction acts against the sliding
    # whatever its direction, which steps in half the time, and which keeps warm starts.
    maximal_coordinates: bool = False
    warm_start: float = 0.1  # share of the last step's contact impulses that a step starts from, in maximal coordinates
    # A body that is let go is given half a step of gravity in its first one, so that the way that it falls is exact.
    exact_fall: bool = False
    # [m/s] While something is faster, what overlaps is parted without being given speed, by this many iterations.
    lively_speed: float | None = None
    lively_iterations: int = 0
    lively_parts: int = 1  # into so many at least steps are then split
    # What slides then is held against its sliding alone, by Coulomb's cone, and not across it as well.
    sliding_cones: bool = False
    # Steps are split while the heaviest that is awake has more than this many times the mass of the lightest, by the
    # root of what it has more, into no more than so many parts.
    most_mass_ratio: float | None = None
    most_parts: int = 16
    # Contact forces start from nothing, so that bodies which begin to press fall freely for a step, and the kick by
    # which that is taken back grows with the step: so many of the first steps are split into so many parts, and
    # as many again where what hits something pushes on after them.
    first_steps: int = 0
    first_parts: int = 1
    # [m] While one of them may hit something no body gets further in a part of these, or a corner that has gone in
    # deeper than it overlaps sideways is parted sideways, and slips past what it should hit.
    first_travel: float | None = None
    first_iterations: int = 0  # of the contact solver then, if that is more: a hit begins with no impulse to start from
    # [engine s/kg] Constraint force mixing of contacts then: they give way a little, and what lies on several others
    # shares its load out among them anew. What is rigid leaves shares as a shock leaves them.
    first_cfm: float = 0.0

    def numerics(self) -> Iterator[str]:
        yield f"{self.iterations} iterations"
        yield f"contact ERP {self.contact_erp:g}"
        yield f"breaking threshold {self.breaking_threshold:g} of half a diagonal, scale {self.scale:g}"
        yield f"friction anchor {'on' if self.friction_anchor else 'off'}"
        yield f"damping {self.linear_damping:g} linear and {self.angular_damping:g} angular"

    def refined(self) -> Self:
        return replace(super().refined(), iterations=2 * self.iterations)

    def suffice_for(self, wanted: Self) -> bool:
        return super().suffice_for(wanted) and self.scale >= wanted.scale

    def scaled(self, scene: SceneScale) -> Self:
        """As of every engine, where the settings were chosen for the usual scene; not as it comes, or as published.

        The engine sees most bricks as large as the usual ones, so that what it takes for little is.
        """
        if self.lively_speed is None or self.most_travel is None:
            return self
        slower = scene.thickest_side / scene.times(scene.thickest_side)
        # What is compared with this allows for a fall until the next look, which is no motion yet.
        seen = self.lively_speed - SAMPLING * USUAL_GRAVITY
        first = self.first_travel
        return replace(
            super().scaled(scene),
            first_travel=None if first is None else first * power_of_two(scene.smallest_side),
            scale=self.scale / power_of_two(scene.median_diagonal),
            lively_speed=max(self.lively_speed * slower, seen * slower + SAMPLING * scene.gravity),
        )
