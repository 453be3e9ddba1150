"""What leans is held by no more friction than Coulomb's cone allows.

PyBullet has two friction forces at a contact point, along the sliding and across it, and each may be as strong as
Coulomb allows by itself. Where nothing slides, "along" is the direction of whatever noise there is, and a ladder or an
inverted V can stand with up to 1.4 times the friction that there is. A speed far below all that anybody sees, but far
above the noise, turns "along" to where the load pulls; if the cone does not hold it then, it slips.
"""

from dataclasses import dataclass, field
from math import hypot

from stability.engines.pybullet.brick_bodies import BrickBodies
from stability.engines.pybullet.pair_friction import PairFriction
from stability.geometry.vectors import add_scaled, norm, scale, subtract
from stability.model import BodyId, Vec3

EVERY = 8  # steps between looks: what slips begins so much later at most
BEYOND = 1.005  # times as much friction as the cone allows: less is let be
NUDGE = 1e-5  # [engine m/s] a micrometre a second for KAPLA planks; what stands trembles at a tenth of that, or less
NOTHING: Vec3 = (0.0, 0.0, 0.0)


@dataclass
class FrictionCones:
    """Lets bricks with rounded edges slip as soon as Coulomb does, if the settings say so."""

    bricks: BrickBodies
    pairs: PairFriction
    _steps_to_look: int = field(default=EVERY, init=False)

    def look(self) -> None:
        """Look after a step, if it is time to."""
        self._steps_to_look -= 1
        if self.bricks.maker.settings.friction_cones and self._steps_to_look <= 0:
            self._steps_to_look = EVERY
            if not self.bricks.stepper.lively:
                self._let_slip()

    def _let_slip(self) -> None:
        """Nudge every brick that leans at rest and is held by too much, against what holds it."""
        bodies = self.bricks.bodies
        for name in sorted(self.bricks.rounded & bodies.numbers.keys(), key=bodies.numbers.__getitem__):
            too_much_W = self._held_beyond(name)
            strength = norm(too_much_W)  # 0 also of forces whose squares are: those hold nothing
            if strength > 0.0 and not self.bricks.holds(name):
                velocity, angular_velocity = bodies.raw_motion(name)
                slips = add_scaled(velocity, -NUDGE / strength, too_much_W)
                bodies.set_raw_motion(name, slips, angular_velocity)

    def _held_beyond(self, name: BodyId) -> Vec3:
        """The sum of the friction forces on a brick that are outside of their cones [engine N]."""
        total_W = NOTHING
        for point in self.bricks.bodies.raw_contacts(name):
            normal_force, along, way, across, other_way = point[9:14]
            friction = self.pairs.asked(name, self.bricks.bodies.names[point[2]])
            if hypot(along, across) > BEYOND * friction * normal_force:
                # PyBullet's friction acts on the other body.
                total_W = subtract(total_W, add_scaled(scale(along, way), across, other_way))
        return total_W
