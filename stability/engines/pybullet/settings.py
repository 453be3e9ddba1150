"""All settings of PyBullet that affect results; importing them does not import the engine."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import ClassVar, Self

from stability.engines.protocol import EngineSettings, Package
from stability.engines.scene_scale import SAMPLING, USUAL_GRAVITY, SceneScale, power_of_two


@dataclass(frozen=True, kw_only=True)
class PyBulletSettings(EngineSettings):
    """Settings of PyBullet; the adapter applies `scale`."""

    package: ClassVar[Package] = Package(
        "pybullet", "pip install pybullet, with Python 3.11, the newest version with wheels"
    )
    world: ClassVar[str] = "stability.engines.pybullet.world:PyBulletWorld"

    iterations: int  # of the contact solver, per step
    contact_erp: float  # share of a contact's overlap that one step removes
    # Gap at which a contact is dropped, as a share of half the diagonal of a brick. (PyBullet scales its threshold by
    # the size of a shape.)
    breaking_threshold: float
    # Froude scaling: the engine uses lengths x scale and times x sqrt(scale), which does not change gravity or physics
    # and lifts small bricks above the solver's absolute thresholds.
    scale: float = 1.0
    # Shares of a velocity lost per engine second, which is 1 / sqrt(scale) scene seconds. PyBullet multiplies them by
    # 1 + velocity, in its own units.
    linear_damping: float = 0.0
    angular_damping: float = 0.0
    residual_threshold: float = 0.0  # the solver stops below this residual; 0 makes it use all its iterations
    friction_anchor: bool = False  # springs in the contact plane that hold resting contacts in place
    friction_erp: float = 0.2  # share of the slip of an anchored contact that one step removes
    contact_slop: float = 1e-5  # [engine m] overlap that the solver does not correct
    # Edge radius as a share of a brick's smallest side, within its outer size, so that contacts along an edge get the
    # correct normal; 0 leaves edges sharp, and their contacts get face normals.
    edge_rounding: float = 0.0
    # Repeats the contact detection along an edge as soon as the contact has slid so far that its normal changes.
    fresh_edges: bool = False
    # Bricks with rounded edges collide with half-spaces instead of large boxes while all bodies are slow.
    half_spaces: bool = False
    # Depth by which bricks with rounded edges sink in under their own weight, as a share of their smallest side, so
    # that all contact points carry load although each step finds only one; 0 makes contacts hard.
    sinking: float = 0.0
    # Limits the friction on leaning bricks at rest to Coulomb's cone instead of the pyramid around it.
    friction_cones: bool = False
    # Bodies in maximal coordinates, not as roots of trees of links: this solver's friction acts against the sliding in
    # every direction, it takes half the time, and it keeps warm starts.
    maximal_coordinates: bool = False
    warm_start: float = 0.1  # share of the last step's contact impulses that a step starts from, in maximal coordinates
    # Gives a released body half a step of gravity in its first step, which makes the path of its fall exact.
    exact_fall: bool = False
    # [m/s] While a body is faster, overlaps are removed without adding velocity, in this many iterations.
    lively_speed: float | None = None
    lively_iterations: int = 0
    lively_parts: int = 1  # least number of sub-steps while a body is faster
    # Limits friction on sliding bricks to Coulomb's cone while a body is faster, without friction across the sliding.
    sliding_cones: bool = False
    # Mass ratio of the awake bodies above which steps are split, by the root of the excess, and the most sub-steps.
    most_mass_ratio: float | None = None
    most_parts: int = 16
    # Contact forces start at 0, so bodies with new contacts fall freely for a step, and the correcting kick grows with
    # the step. So the first steps, of this number, have this many sub-steps; if a body still pushes the body that it
    # hit, as many steps again.
    first_steps: int = 0
    first_parts: int = 1
    # [m] Most travel of a body in a sub-step of these while a hit is possible. A corner that enters deeper than it
    # overlaps sideways would be pushed out sideways, and miss the body that it should hit.
    first_travel: float | None = None
    first_iterations: int = 0  # least iterations in these steps: a hit has no impulse to start from
    # [engine s/kg] Constraint force mixing of contacts in these steps: they yield slightly, so a brick on several
    # supports redistributes its load. Rigid contacts keep the distribution that a shock leaves.
    first_cfm: float = 0.0

    def numerics(self) -> Iterator[str]:
        yield f"{self.iterations} iterations"
        yield f"contact ERP {self.contact_erp:g}"
        yield f"breaking threshold {self.breaking_threshold:g} of half a diagonal, scale {self.scale:g}"
        yield f"friction anchor {'on' if self.friction_anchor else 'off'}"
        yield f"damping {self.linear_damping:g} linear and {self.angular_damping:g} angular"

    def refined(self) -> Self:
        return replace(super().refined(), iterations=2 * self.iterations)

    def suffice_for(self, required: Self) -> bool:
        return super().suffice_for(required) and self.scale >= required.scale

    def scaled(self, scene: SceneScale) -> Self:
        """Adapt settings chosen for the reference scene; PyBullet's defaults and published settings stay.

        The engine scale gives the median brick its reference size, so that the solver's thresholds remain small.
        """
        if self.lively_speed is None or self.most_travel is None:
            return self
        slower = scene.thickest_side / scene.times(scene.thickest_side)
        # The maximum speed includes a free fall until the next check, which is no motion yet.
        speed_without_fall = self.lively_speed - SAMPLING * USUAL_GRAVITY
        first = self.first_travel
        return replace(
            super().scaled(scene),
            first_travel=None if first is None else first * power_of_two(scene.smallest_side),
            scale=self.scale / power_of_two(scene.median_diagonal),
            lively_speed=max(self.lively_speed * slower, speed_without_fall * slower + SAMPLING * scene.gravity),
        )
