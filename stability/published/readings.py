"""What the published text leaves open, and each way to read it. The method runs with one choice of all of them.

docs/decisions/0001 and 0009 say why the defaults are what they are, and docs/method.md what the others come to.
"""

from dataclasses import dataclass
from enum import Enum


class Closest(Enum):
    """Which point of a contact is "the contact point closest to the centre of mass"."""

    CORNER = "corner"  # one of the contact points
    POINT = "point"  # any point of the contact area


class ActsAt(Enum):
    """Where the mass acts that one of several supports is given."""

    CONTACT = "contact"  # at the centre of its contact area, to which Eq. 6 takes the lever
    COM_ABOVE = "com above"  # at com above of the brick that hands it on, as Eq. 1 and Eq. 10 are written


class Merge(Enum):
    """How a load is shared by two supports neither of which could bear it alone (merge case 3)."""

    TORQUES = "torques"  # by the torque about a pivot on the other support, as published (Eq. 3 to 9)
    LEVER_RULE = "lever rule"  # not published: by the lever rule, so that load and moment are both kept


class SecondObjects(Enum):
    """Which moving bricks are "second impact objects", whose hits count for nothing (section 3.6.1)."""

    EVER_STACKED = "ever stacked"  # every brick that has been part of the stack, also long after it was woken
    NONE = "none"  # none that touches the stack by itself: every moving brick hits, with its own energy


class Square(Enum):
    """What the angle of Eq. 7 is measured against where a brick leans; its sine divides the force."""

    FORCE = "force"  # the force, which is square to the lever: no angle at all
    GRAVITY = "gravity"  # gravity, as in the base model
    NORMAL = "normal"  # the normal of the contact that is leaned on


@dataclass(frozen=True, slots=True)
class Readings:
    """One choice of each."""

    pivot: Closest = Closest.CORNER  # of merge case 3
    acts_at: ActsAt = ActsAt.CONTACT  # in plan, on two supports: merge case 3, Eq. 10
    equal_acts_at: ActsAt = ActsAt.COM_ABOVE  # in plan, on more than two: merge case 2
    height_acts_at: ActsAt = ActsAt.COM_ABOVE  # how high, on two or more; only the energy of an impact asks for it
    merge: Merge = Merge.TORQUES
    second_objects: SecondObjects = SecondObjects.EVER_STACKED
    leaning_pivot: Closest = Closest.POINT
    leaning_angle: Square = Square.FORCE


AS_READ = Readings()
