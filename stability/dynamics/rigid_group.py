"""Rigid groups of bricks: mass, centre, inertia, and the states of the bricks.

Frame G of a group: its origin is the centre of mass, its axes are the principal axes of inertia.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stability.geometry.placed_shape import diagonal_times, inertia_times, principal_turn
from stability.geometry.vectors import add, body_axes, cross, inverse, multiply, principal_axes, rotate, scale, subtract
from stability.model import BodyId, BodyState, Brick, Pose, Vec3

Matrix = NDArray[np.float64]
Rows = NDArray[np.int_]
EQUALLY_NEAR = 1e-7  # [m] far above rounding, far below the gaps of contacts


@dataclass(frozen=True, slots=True)
class RigidGroup:
    """Bricks as one rigid body."""

    bricks: Mapping[BodyId, Brick]
    places_G: Mapping[BodyId, Pose]  # poses of the bricks in frame G
    pose: Pose  # initial pose of the group
    mass: float  # [kg]
    moments: Vec3  # principal moments of inertia [kg m2]


def grouped(bricks: Iterable[tuple[Brick, Pose]]) -> RigidGroup:
    """Combine bricks at their poses."""
    placed = list(bricks)
    mass = sum(brick.mass for brick, _ in placed)
    centre = (0.0, 0.0, 0.0)
    for brick, pose in placed:
        centre = add(centre, scale(brick.mass / mass, pose.position_W))
    inertia: Matrix = sum((_inertia(brick, pose, centre) for brick, pose in placed), np.zeros((3, 3)))
    moments, turn = principal_axes(inertia.tolist())
    pose_WG = Pose(centre, turn)
    return RigidGroup(
        {brick.id: brick for brick, _ in placed},
        {brick.id: seen_from(pose_WG, pose) for brick, pose in placed},
        pose_WG,
        mass,
        moments,
    )


def common_motion(group: RigidGroup, states: Mapping[BodyId, BodyState]) -> tuple[Vec3, Vec3]:
    """Return velocity [m/s] and spin [rad/s], in W, of a group with the momentum and angular momentum of its bricks."""
    velocity = twist = (0.0, 0.0, 0.0)
    for name, brick in group.bricks.items():
        state = states[name]
        velocity = add(velocity, scale(brick.mass / group.mass, state.velocity_W))
        arm = subtract(state.pose.position_W, group.pose.position_W)
        twist = add(twist, scale(brick.mass, cross(arm, state.velocity_W)))
        twist = add(twist, inertia_times(brick, state.pose.orientation, state.angular_velocity_W))
    a, b, c = group.moments
    return velocity, diagonal_times((1.0 / a, 1.0 / b, 1.0 / c), group.pose.orientation, twist)


def _inertia(brick: Brick, pose: Pose, centre: Vec3) -> Matrix:
    """Return the inertia of a brick about a point of W (3, 3) [kg m2], by the parallel axis theorem."""
    axes = np.array(body_axes(principal_turn(brick.shape, pose.orientation))).T
    arm = np.array(subtract(pose.position_W, centre))
    own: Matrix = axes @ np.diag(brick.shape.moments(brick.mass)) @ axes.T
    about: Matrix = own + brick.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return about


def seen_from(frame: Pose, pose: Pose) -> Pose:
    """Convert a pose from W to a frame."""
    back = inverse(frame.orientation)
    return Pose(rotate(back, subtract(pose.position_W, frame.position_W)), multiply(back, pose.orientation))


def within(frame: Pose, pose: Pose) -> Pose:
    """Convert a pose from a frame to W."""
    return Pose(
        add(frame.position_W, rotate(frame.orientation, pose.position_W)),
        multiply(frame.orientation, pose.orientation),
    )


def member_state(group: BodyState, place_G: Pose) -> BodyState:
    """Return pose and motion of a brick of a moving group: v + w x r."""
    pose = within(group.pose, place_G)
    arm = subtract(pose.position_W, group.pose.position_W)
    return BodyState(pose, add(group.velocity_W, cross(group.angular_velocity_W, arm)), group.angular_velocity_W)


@dataclass(frozen=True, slots=True, eq=False)
class GroupSurfaces:
    """Faces of the bricks of a group, in arrays, to find the touching brick: an engine reports only the group."""

    names: tuple[BodyId, ...]
    centres_G: Matrix  # (n, 3) [m]
    axes_G: Matrix  # (n, 3, 3), rows are the body axes
    normals: Matrix  # (faces, 3) of all bricks in order, in body axes
    reaches: Matrix  # (faces,) of each face from the centre of mass of its brick [m]
    first: Rows  # (n,) index of the first face of each brick

    def brick_at(self, point_G: Vec3) -> BodyId:
        """Return the brick whose surface is nearest to a point that is not deep inside."""
        local = np.einsum("nij,nj->ni", self.axes_G, np.array(point_G) - self.centres_G)
        faces = np.diff(self.first, append=len(self.reaches))
        beyond = np.einsum("fi,fi->f", self.normals, np.repeat(local, faces, axis=0)) - self.reaches
        outside = np.maximum.reduceat(beyond, self.first)
        # The first of equally near bricks, independent of rounding.
        return self.names[int(np.argmax(outside <= outside.min() + EQUALLY_NEAR))]


def surfaces(group: RigidGroup) -> GroupSurfaces:
    """Return the faces of the bricks of a group."""
    places, shapes = group.places_G.values(), [group.bricks[name].shape for name in group.places_G]
    ends = np.cumsum([len(shape.faces) for shape in shapes])
    return GroupSurfaces(
        tuple(group.places_G),
        np.array([place.position_W for place in places]),
        np.array([body_axes(place.orientation) for place in places]),
        np.array([face.normal for shape in shapes for face in shape.faces]),
        np.array([shape.reach(face.normal) for shape in shapes for face in shape.faces]),
        np.concatenate(([0], ends[:-1])),
    )
