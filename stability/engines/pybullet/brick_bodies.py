"""The bricks of a PyBullet world, each with a body of its own, with sharp or rounded edges."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from stability.engines.own_bodies import OwnBodies
from stability.engines.pybullet.anchors import Anchors
from stability.engines.pybullet.body_making import ALL, ROUNDED, SHARP, BodyMaker
from stability.engines.pybullet.client_bodies import ClientBodies
from stability.engines.pybullet.planes import Planes
from stability.engines.pybullet.pybullet_binding import pybullet
from stability.engines.pybullet.stepper import Stepper
from stability.geometry.vectors import scale
from stability.mechanics.rubbing import Pressed
from stability.model import AT_REST, BodyId, BodyState, Brick, Pose, Vec3
from stability.shapes.in_pose import principal_turn


@dataclass
class BrickBodies:
    """Bricks that come and go, are held and let go, and change their edges; none is joined to another here."""

    own: OwnBodies
    bodies: ClientBodies
    maker: BodyMaker
    planes: Planes
    stepper: Stepper
    anchors: Anchors = field(init=False)
    rounded: set[BodyId] = field(default_factory=set, init=False)  # those whose edges are rounded
    displaced: bool = field(
        default=True, init=False
    )  # whether one was put elsewhere since somebody looked how they lie
    let_go: dict[BodyId, None] = field(default_factory=dict, init=False)  # since somebody looked what touches them

    def __post_init__(self) -> None:
        self.anchors = Anchors(self.bodies, self.maker.settings.friction_anchor)

    def add(self, brick: Brick, pose: Pose, velocity_W: Vec3) -> None:
        """Set a brick down at rest, or let it go with a velocity of its centre [m/s]."""
        if not self.own.bricks:
            self.planes.begin_about(brick, pose.position_W)
        self.planes.reach_beyond(brick, pose.position_W)
        square = self.planes.lies_square(pose, brick.shape)
        position, turn = scale(self.bodies.scale, pose.position_W), principal_turn(brick.shape, pose.orientation)
        self.maker.brick(brick, position, turn, rounded=not square)
        self.own.add_brick(brick)
        if velocity_W != AT_REST:
            self.bodies.set_motion(brick.id, velocity_W, AT_REST)
        if square:
            self.anchors.add(brick.id)
        else:
            self.rounded.add(brick.id)
        self.comes_free(brick.id)

    def remove(self, brick: BodyId) -> None:
        """Take a brick out; its name is free again."""
        self.bodies.remove(brick)
        self.own.remove_brick(brick)
        self.stays(brick)
        self.anchors.remove(brick)
        self.rounded.discard(brick)

    def states(self, names: Iterable[BodyId]) -> dict[BodyId, BodyState]:
        """Pose and motion of bodies."""
        return self.stepper.fall.corrected(self.bodies.states(names))

    def freeze(self, brick: BodyId) -> None:
        """Hold a brick where it is."""
        self.bodies.hold(brick)
        self.stays(brick)

    def holds(self, brick: BodyId) -> bool:
        """Whether a brick is held."""
        return self.bodies.mass(brick) == 0.0

    def wake(self, brick: BodyId) -> None:
        """Let a brick go that was held."""
        self.bodies.let_go(brick, self.own.bricks[brick].mass)
        self.comes_free(brick)
        if self.maker.settings.edge_rounding:
            self.maker.weigh_brick(self.own.bricks[brick])

    def weigh(self, brick: BodyId, times: float) -> None:
        """Give a brick that is not held so many times its mass."""
        self.maker.weigh_brick(self.own.bricks[brick], times)

    def press(self, brick: BodyId, pressed: Sequence[Pressed]) -> None:
        """Let forces act on a brick that is not held."""
        self.stepper.presses.press(self.own.bricks[brick], self.states([brick])[brick], pressed)

    def put_at(self, brick: BodyId, pose: Pose) -> None:
        """Put a brick somewhere else."""
        self.bodies.put(brick, pose)
        self.displaced = True

    def set_state(self, brick: BodyId, state: BodyState) -> None:
        """Put a brick that is not held somewhere else, in motion."""
        self.put_at(brick, state.pose)
        self.stays(brick)  # as for falling: its speed is of this moment, whatever it touches
        self.bodies.set_motion(brick, state.velocity_W, state.angular_velocity_W)

    def collide_alone(self, brick: BodyId, body: int) -> None:
        """Let the body of a brick, which met nothing, meet all that it does by itself."""
        round_group = self.maker.settings.half_spaces and brick in self.rounded
        self.bodies.numbers[brick] = body
        self.maker.meet([body], ROUNDED if round_group else SHARP, ALL)

    def swap(self, brick: BodyId) -> None:
        """Give a brick a body with the other kind of edges: same place, motion, mass and name."""
        self.rounded ^= {brick}
        self.renew(brick)

    def renew(self, brick: BodyId) -> None:
        """Give a brick another body, to which nothing is known to touch: same place, motion, mass and name."""
        number, client = self.bodies.numbers[brick], self.bodies.client
        position, orientation = pybullet.getBasePositionAndOrientation(number, client)
        velocity, angular_velocity = self.bodies.raw_motion(brick)
        self.bodies.remove(brick)
        self.maker.brick(self.own.bricks[brick], position, orientation, rounded=brick in self.rounded)
        self.bodies.set_raw_motion(brick, velocity, angular_velocity)
        self.anchors.renew(brick)

    def comes_free(self, body: BodyId) -> None:
        """Note that a body is awake from now on."""
        self.stepper.look_again()
        self.stepper.fall.begin(body)
        self.let_go[body] = None

    def stays(self, body: BodyId) -> None:
        """Note that a body is not awake any more."""
        self.stepper.look_again()
        self.stepper.fall.end(body)
        self.stepper.presses.leave(body)
