"""Compiled MuJoCo scene as plain values: bodies with joints, geoms and masses."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from stability.engines.mujoco.binding import mujoco
from stability.model import Quaternion, Vec3


@dataclass(frozen=True, slots=True)
class CompiledGeom:
    """Shape of a body, in the frame of the body, in SI units."""

    kind: str  # such as `box`, `mesh`, `plane`
    size: Vec3  # half the sides of a box
    place: Vec3
    turn: Quaternion
    friction: float  # Coulomb coefficient of sliding
    corners: tuple[Vec3, ...] = ()  # of a mesh, in the frame of the shape
    faces: tuple[tuple[int, ...], ...] = ()


@dataclass(frozen=True, slots=True)
class CompiledBody:
    """Body, in the frame of its parent, in SI units."""

    joints: tuple[str, ...]  # such as `free`, `hinge`
    geoms: Sequence[CompiledGeom]
    mass: float
    place: Vec3
    turn: Quaternion
    centre_of_mass: Vec3  # in its own frame


def compiled_scene(xml: str, files: Mapping[str, bytes]) -> list[CompiledBody]:
    """Compile a scene and return its bodies, the world first, in file order; `files` are mesh files by name.

    Raises ValueError with MuJoCo's message if it cannot load the scene.
    """
    model = mujoco.MjSpec.from_string(xml, assets=dict(files)).compile()
    return [_body(model, number) for number in range(model.nbody)]


def _body(model: Any, number: int) -> CompiledBody:  # noqa: ANN401 -- the engine is untyped
    joints, geoms = (
        range(first[number], first[number] + count[number])
        for first, count in ((model.body_jntadr, model.body_jntnum), (model.body_geomadr, model.body_geomnum))
    )
    return CompiledBody(
        joints=tuple(_word(mujoco.mjtJoint(model.jnt_type[joint]), "mjJNT_") for joint in joints),
        geoms=[_geom(model, geom) for geom in geoms],
        mass=float(model.body_mass[number]),
        place=_three(model.body_pos[number]),
        turn=_turn(model.body_quat[number]),
        centre_of_mass=_three(model.body_ipos[number]),
    )


def _geom(model: Any, number: int) -> CompiledGeom:  # noqa: ANN401 -- likewise
    kind = _word(mujoco.mjtGeom(model.geom_type[number]), "mjGEOM_")
    place, turn = _three(model.geom_pos[number]), _turn(model.geom_quat[number])
    friction = float(model.geom_friction[number][0])
    if kind != "mesh":
        return CompiledGeom(kind, _three(model.geom_size[number]), place, turn, friction)
    mesh = int(model.geom_dataid[number])
    corners, faces = (
        of[first[mesh] : first[mesh] + count[mesh]]
        for of, first, count in (
            (model.mesh_vert, model.mesh_vertadr, model.mesh_vertnum),
            (model.mesh_face, model.mesh_faceadr, model.mesh_facenum),
        )
    )
    loops = tuple(tuple(map(int, face)) for face in faces)
    size = _three(model.geom_size[number])
    return CompiledGeom(kind, size, place, turn, friction, tuple(map(_three, corners)), loops)


def _word(named: Any, prefix: str) -> str:  # noqa: ANN401 -- likewise
    return str(named.name).removeprefix(prefix).lower()


def _three(parts: Any) -> Vec3:  # noqa: ANN401 -- likewise
    x, y, z = (float(part) for part in parts)
    return (x, y, z)


def _turn(quaternion: Any) -> Quaternion:  # noqa: ANN401 -- likewise
    w, x, y, z = (float(part) for part in quaternion)
    return (x, y, z, w)
