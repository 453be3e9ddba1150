"""Reads bodies from MJCF and URDF."""

import re
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import redirect_stderr
from dataclasses import dataclass, replace
from fractions import Fraction
from io import StringIO
from math import inf, isfinite
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from stability.contact_law import Rule
from stability.model import Quaternion, Vec3
from stackdsl.diagnostics import Span
from stackdsl.importers.load import (
    Exact3,
    ImportedBox,
    ImportedLoad,
    ImportedSurfaces,
    LoadReading,
    UnreadableLoadError,
)
from stackdsl.importers.meshes import ImportedMesh, brick_name, merged, solid_brick
from stackdsl.importers.text_positions import (
    FURTHEST,
    HEAVIEST,
    ROUGHEST,
    SHORTEST,
    Element,
    number_of,
    refuse_invalid_numbers,
    supported_subset,
    xml_of,
    xml_text,
)
from stackdsl.language.bricks import file_mesh
from stackdsl.language.imports import Import
from stackdsl.language.mesh_files import mesh_kind
from stackdsl.language.quantities import InputError

if TYPE_CHECKING:
    from urdf_parser_py.urdf import Link, Robot

    from stability.engines.mujoco.compiled_scene import CompiledBody


# Bodies of MJCF and URDF. Each has one shape, with a pose in the body; the body has a pose in the scene.


CURVED: Final = frozenset({"sphere", "cylinder", "capsule"})  # bodies along the z axis of their frame
ROUNDED: Final = 1e-9  # rounding error of a centre of mass (share of a side), of a quaternion and of a height [m]
DIGITS: Final = 12  # decimals of a metre, or of a degree


@dataclass(frozen=True, slots=True)
class RobotBody:
    """A body of one shape, in SI units; quaternions are x, y, z, w."""

    name: str
    span: Span
    shape: str  # `box`, `mesh`, one of `CURVED`, or the name of a shape that is not supported
    size: Vec3 | None  # sides of a box, or of the box around a curved body
    corners: Sequence[Vec3]  # of a mesh, in the shape frame
    faces: Sequence[Sequence[int]]
    mass: Fraction
    place: Vec3  # of the body, in the scene frame
    turn: Quaternion
    shape_place: Vec3  # in the body frame
    shape_turn: Quaternion
    centre_of_mass: Vec3  # in the body frame
    friction: Fraction | None = None  # Coulomb coefficient; None to use that of the scenario


def brick_of(reading: LoadReading, body: RobotBody) -> ImportedBox | None:
    """Return the brick of a body; report and return None if it cannot be a brick."""
    hint = f"to ignore it, write `ignore: ['{body.name}']`"
    if body.shape not in {"box", "mesh"} | CURVED:
        message = f"'{body.name}' is a {body.shape}, but a brick must be a box, a round body or a convex mesh"
        reading.undetermined(body.span, message, hint)
        return None
    if not _has_valid_numbers(reading, body):
        return None
    turn = Rotation.from_quat(body.turn) * Rotation.from_quat(body.shape_turn)
    centre = np.array(body.place) + Rotation.from_quat(body.turn).apply(body.shape_place)
    centre_of_mass = np.array(body.place) + Rotation.from_quat(body.turn).apply(body.centre_of_mass)
    brick = (_box if body.size else _solid)(reading, body, turn, centre, centre_of_mass)
    return brick and replace(brick, friction=body.friction)


def _has_valid_numbers(reading: LoadReading, body: RobotBody) -> bool:
    """Return whether the numbers of a body are valid for a brick; report the first invalid one."""
    if not 0 < body.mass <= HEAVIEST:
        reading.wrong(
            body.span, f"'{body.name}' has an invalid mass of {float(body.mass):g} kg", "write a positive number"
        )
        return False
    if not np.isfinite([*body.turn, *body.shape_turn]).all():
        reading.wrong(body.span, f"the rotation of '{body.name}' is not finite", "write finite numbers")
        return False
    lengths = np.array([body.place, body.shape_place, body.centre_of_mass, *body.corners])
    if not (np.abs(lengths) <= float(FURTHEST)).all():  # also if one is not a number
        message = f"'{body.name}', its centre of mass or one of its corners is more than 10 km from the origin"
        reading.wrong(body.span, message, "correct the numbers or their unit")
        return False
    if body.friction is not None and not 0 <= body.friction <= ROUGHEST:
        message = f"'{body.name}' has an invalid friction coefficient of {float(body.friction):g}"
        reading.wrong(body.span, message, f"write a number from 0 to {ROUGHEST}")
        return False
    return True


def _box(
    reading: LoadReading,
    body: RobotBody,
    turn: Rotation,
    centre: NDArray[np.float64],
    centre_of_mass: NDArray[np.float64],
) -> ImportedBox | None:
    assert body.size is not None
    if not SHORTEST <= min(body.size) <= max(body.size) <= FURTHEST:
        reading.wrong(
            body.span, f"'{body.name}' has invalid sides of {body.size} m", "correct the numbers or their unit"
        )
        return None
    with warnings.catch_warnings():  # about angles that are not unique; any of them will do
        warnings.simplefilter("ignore", UserWarning)
        angles = turn.as_euler("xyz", degrees=True)
    offset = turn.inv().apply(centre_of_mass - centre)
    is_off = bool(np.abs(offset).max() > ROUNDED * max(body.size))
    return ImportedBox(
        body.name,
        _exact(body.size),
        _exact(centre),
        body.mass,
        body.span,
        _exact(angles),
        centre_of_mass=_exact(offset) if is_off else None,
        curved=body.shape if body.shape in CURVED else None,
    )


def _around(shape: str, radius: float, length: float) -> Vec3 | None:
    """Return the sides of the box around a curved body, from its radius and the length of its straight part [m]."""
    straight = {"sphere": 2.0 * radius, "cylinder": length, "capsule": length + 2.0 * radius}
    return (2.0 * radius, 2.0 * radius, straight[shape]) if shape in CURVED else None


def _solid(
    reading: LoadReading,
    body: RobotBody,
    turn: Rotation,
    centre: NDArray[np.float64],
    centre_of_mass: NDArray[np.float64],
) -> ImportedBox | None:
    corners = [_exact(corner) for corner in centre + turn.apply(np.array(body.corners))]
    places, faces = merged(corners, body.faces)
    mesh = ImportedMesh(body.name, places, faces, body.span)
    return solid_brick(reading, mesh, mass=body.mass, centre_of_mass=_exact(centre_of_mass), only_convex=True)


def _exact(parts: Sequence[float] | NDArray[np.float64]) -> Exact3:
    x, y, z = (Fraction(repr(round(float(part), DIGITS))) for part in parts)
    return (x, y, z)


# MJCF scenes, read by MuJoCo itself: bodies that are free to move, each with one box, round body or convex mesh.
#
# MuJoCo gets only the elements that define poses, shapes and masses. Mesh files are read from the folder of the scene.
# A level plane at height 0 is the ground. If any shape gives a friction, each body has the friction that MuJoCo assigns
# to it, and the higher one of two bodies in contact counts.


MJCF_MISSING: Final = "MuJoCo, which reads MJCF, is not installed"
_MJCF_SUPPORTED: Final[Mapping[str, frozenset[str]]] = {  # children by parent
    "mujoco": frozenset({"compiler", "default", "asset", "worldbody"}),
    "default": frozenset({"default", "geom", "mesh", "joint"}),
    "asset": frozenset({"mesh"}),
    "worldbody": frozenset({"body", "geom"}),
    "body": frozenset({"body", "geom", "freejoint", "joint", "inertial"}),
}
# Elements about display, sensors and solvers, which do not affect statics.
_MJCF_HARMLESS: Final = frozenset(
    {"option", "size", "visual", "statistic", "material", "texture", "light", "camera", "site", "sensor", "keyframe"}
)
_LOOKS: Final = frozenset({"material", "rgba", "group"})  # attributes
FRICTION: Final = "friction"
_CONTACTS: Final = frozenset({"condim", "priority", "margin", "gap", "contype", "conaffinity"})
# Attribute of `compiler`. It is left out, so that a fixed body stays a body of its own, which is then reported.
_FUSES: Final = "fusestatic"
_FOLDERS: Final = ("meshdir", "assetdir", "texturedir")


def read_mjcf(reading: LoadReading, _: Import) -> ImportedLoad:
    """Read the free bodies of a scene, in file order. Raises UnreadableLoadError."""
    root = xml_text(reading)
    if root.tag != "mujoco":
        reading.wrong(root.span, f"the root element is <{root.tag}> instead of <mujoco>", "import an MJCF file")
        reading.end()
    scene = supported_subset(reading, root, _is_supported_mjcf, _MJCF_HARMLESS)
    scene = _without_ignored_of_mjcf(reading, scene)
    _skip_contact_settings(reading, root, scene)
    refuse_invalid_numbers(reading, scene)
    _refuse_generated_meshes(reading, scene)
    has_friction = _has_friction(reading, scene)
    files = _files(reading, scene)
    reading.end()
    world, *others = _compiled(reading, scene, files)
    grounds = list(_ground_frictions(reading, scene, world))
    bricks = [brick_of(reading, body) for body in _bodies(reading, scene, others, has_friction)]
    reading.end()
    load = reading.load([brick for brick in bricks if brick is not None])
    return replace(load, surfaces=ImportedSurfaces(Rule.HIGHER, max(grounds, default=None))) if has_friction else load


def _is_supported_mjcf(parent: Element, child: Element) -> bool:
    return child.tag in _MJCF_SUPPORTED.get(parent.tag, ())


def _skip_contact_settings(reading: LoadReading, root: Element, scene: Element) -> None:
    """Report settings of contacts and of gravity, which are not supported, unless the author ignores them."""
    for element in scene.all("geom"):
        for key in sorted(_CONTACTS.intersection(element.attributes)):
            reading.skip(key, element.span, harmless=False)
    for option in root.all("option"):
        if "gravity" in option.attributes:
            reading.skip("gravity", option.span, harmless=False)


def _refuse_generated_meshes(reading: LoadReading, scene: Element) -> None:
    """Refuse the meshes that MuJoCo generates: a few digits can ask for all the memory there is."""
    for mesh in scene.all("mesh"):
        for key in sorted({"builtin", "plugin"}.intersection(mesh.attributes)):
            message = f"`{key}` lets MuJoCo generate the mesh, which is not supported"
            reading.wrong(mesh.span, message, "write the corners of the mesh as `vertex`, or save the mesh as a file")


def _has_friction(reading: LoadReading, scene: Element) -> bool:
    """Return whether the file gives any friction that the author does not ignore."""
    rough = [element for element in scene.all("geom") if FRICTION in element.attributes]
    if rough and FRICTION in reading.ignored:
        reading.skip(FRICTION, rough[0].span, harmless=False)
    return bool(rough) and FRICTION not in reading.ignored


def _without_ignored_of_mjcf(reading: LoadReading, element: Element) -> Element:
    """Return an element without the bodies and geoms that the author ignores."""
    children = []
    for child in element.children:
        name = child.attributes.get("name", "")
        if child.tag in {"body", "geom"} and name in reading.ignored:
            reading.skip(name, child.span, harmless=False)
        else:
            children.append(_without_ignored_of_mjcf(reading, child))
    return Element(element.tag, element.attributes, element.span, element.line, children)


def _files(reading: LoadReading, scene: Element) -> dict[str, bytes]:
    """Read the mesh files, and replace their names in the scene by the keys of the result."""
    folder = ""
    for compiler in scene.all("compiler"):
        folder = compiler.attributes.get("meshdir") or compiler.attributes.get("assetdir") or folder
    files: dict[str, bytes] = {}
    for mesh in scene.all("mesh"):
        if (file := mesh.attributes.get("file")) is not None:
            data = reading.bytes_beside("/".join(filter(None, (folder.rstrip("/"), file))), mesh.span)
            key = f"{len(files)}.{file.rpartition('.')[2]}"
            mesh.attributes.setdefault("name", re.split(r"[/\\]", file)[-1].rpartition(".")[0])
            mesh.attributes["file"] = key
            files[key] = data
    return files


def _compiled(reading: LoadReading, scene: Element, files: dict[str, bytes]) -> "list[CompiledBody]":
    try:
        from stability.engines.mujoco.compiled_scene import compiled_scene  # noqa: PLC0415 -- it comes with an extra
    except ModuleNotFoundError:
        reading.undetermined(scene.span, MJCF_MISSING, "install it: pip install 'stackdsl[mujoco]'")
        raise UnreadableLoadError(reading.mistakes) from None

    def attributes(element: Element) -> dict[str, str]:
        ignored = (FRICTION,) if FRICTION in reading.ignored else ()
        left_out = (*_LOOKS, *_CONTACTS, *ignored, *((*_FOLDERS, _FUSES) if element.tag == "compiler" else ()))
        return {key: value for key, value in element.attributes.items() if key not in left_out}

    try:
        return compiled_scene(xml_of(scene, attributes), files)
    except ValueError as error:
        text = " ".join(str(error).split())
        line = re.search(r"line (?:number=)?(\d+)", text, re.IGNORECASE)
        place = min(int(line[1]), len(reading.page.lines)) - 1 if line else scene.line - 1
        column = len(reading.page.lines[place]) - len(reading.page.lines[place].lstrip())
        span = reading.page.span(place, min(column, max(len(reading.page.lines[place]) - 1, 0)))
        reading.wrong(span, f"MuJoCo reports: {text}", "correct the scene so that MuJoCo loads it")
        raise UnreadableLoadError(reading.mistakes) from error


def _bodies(
    reading: LoadReading, scene: Element, bodies: "list[CompiledBody]", has_friction: bool
) -> Iterator[RobotBody]:
    """Yield the free bodies that MuJoCo compiled, with their frictions if the file gives any; report the others."""
    for number, (element, body) in enumerate(zip(scene.all("body"), bodies, strict=True), start=1):
        name = brick_name(element.attributes.get("name", ""), f"body-{number}")
        if body.joints != ("free",):
            held = "has a hinge or slide joint" if body.joints else "is fixed"
            _unsupported(reading, element, f"'{name}' {held}, but bricks move freely")
        elif len(body.geoms) != 1:
            _unsupported(reading, element, f"'{name}' has {len(body.geoms)} shapes, but a brick must have one")
        elif not isfinite(body.mass + body.geoms[0].friction):
            reading.wrong(element.span, f"the mass or friction of '{name}' is not finite", "write finite numbers")
        else:
            yield _body(element, name, body, has_friction)


def _unsupported(reading: LoadReading, element: Element, message: str) -> None:
    name = element.attributes.get("name")
    hint = (
        f"to ignore it, write `ignore: ['{name}']`"
        if name
        else "to ignore it, give it a name and list that name in `ignore`"
    )
    reading.undetermined(element.span, message, hint)


def _ground_frictions(reading: LoadReading, scene: Element, world: "CompiledBody") -> Iterator[Fraction]:
    """Yield the friction of each ground plane; report all other shapes of the world body."""
    worldbody = scene.first("worldbody")
    elements = [child for child in worldbody.children if child.tag == "geom"] if worldbody is not None else []
    for element, geom in zip(elements, world.geoms, strict=True):
        error = max(abs(geom.turn[0]), abs(geom.turn[1]), abs(geom.place[2]))
        if geom.kind != "plane" or not error <= ROUNDED or not isfinite(geom.friction):
            message = "the shape belongs to the world and is fixed, but only the ground at z = 0 can be fixed"
            _unsupported(reading, element, message)
        else:
            yield Fraction(repr(geom.friction))


def _body(element: Element, name: str, body: "CompiledBody", has_friction: bool) -> RobotBody:
    (geom,) = body.geoms
    x, y, z = geom.size
    return RobotBody(
        name=name,
        span=element.span,
        shape=geom.kind,
        size=(2.0 * x, 2.0 * y, 2.0 * z) if geom.kind == "box" else _around(geom.kind, x, 2.0 * y),
        corners=geom.corners,
        faces=geom.faces,
        mass=Fraction(repr(body.mass)),
        place=body.place,
        turn=body.turn,
        shape_place=geom.place,
        shape_turn=geom.turn,
        centre_of_mass=body.centre_of_mass,
        friction=Fraction(repr(geom.friction)) if has_friction else None,
    )


# URDF robots and objects, read by the parser of ROS: floating links, each with one box or one convex mesh.
#
# A file of one link is one brick at the origin. In a file of several links, the root link has no shape and is the
# world; the bricks are the links that a floating joint connects to it.


URDF_MISSING: Final = "urdf_parser_py, which reads URDF, is not installed"
_URDF_SUPPORTED: Final[Mapping[str, frozenset[str]]] = {
    "robot": frozenset({"link", "joint"}),
    "link": frozenset({"inertial", "collision", "contact"}),
    "contact": frozenset({"lateral_friction"}),
    "inertial": frozenset({"origin", "mass"}),
    "collision": frozenset({"origin", "geometry"}),
    "geometry": frozenset({"box", "mesh", "cylinder", "sphere", "capsule"}),
    "joint": frozenset({"parent", "child", "origin", "axis", "limit"}),
}
_URDF_HARMLESS: Final = frozenset(
    {"visual", "material", "inertia", "inertia_scaling", "dynamics", "safety_controller", "calibration"}
)
_IGNORABLE: Final = frozenset({"contact", "lateral_friction"})
ORIGIN: Final[Vec3] = (0.0, 0.0, 0.0)


def read_urdf(reading: LoadReading, _: Import) -> ImportedLoad:
    """Read the floating links, in file order. Raises UnreadableLoadError."""
    root = xml_text(reading)
    if root.tag != "robot":
        reading.wrong(root.span, f"the root element is <{root.tag}> instead of <robot>", "import a URDF file")
        reading.end()
    ignored = _IGNORABLE & reading.ignored

    def is_supported(parent: Element, child: Element) -> bool:
        return child.tag in _URDF_SUPPORTED.get(parent.tag, ()) and child.tag not in ignored

    subset = supported_subset(reading, root, is_supported, _URDF_HARMLESS)
    subset = _without_ignored_of_urdf(reading, subset)
    refuse_invalid_numbers(reading, subset)
    reading.end()
    robot = _parsed(reading, subset)
    bricks = [brick_of(reading, body) for body in _Links(reading, subset, robot).bodies()]
    reading.end()
    load = reading.load([brick for brick in bricks if brick is not None])
    return (
        replace(load, surfaces=ImportedSurfaces(None)) if any(box.friction is not None for box in load.boxes) else load
    )


def _without_ignored_of_urdf(reading: LoadReading, robot: Element) -> Element:
    """Return the robot without the links that the author ignores, and without the joints of these."""
    names = {link.attributes.get("name", "") for link in robot.children if link.tag == "link"} & reading.ignored
    children = []
    for child in robot.children:
        if child.tag == "link" and child.attributes.get("name") in names:
            reading.skip(child.attributes["name"], child.span, harmless=False)
        elif child.tag != "joint" or not names & {
            end.attributes.get("link", "") for end in child.children if end.tag == "child"
        }:
            children.append(child)
    return Element(robot.tag, robot.attributes, robot.span, robot.line, children)


def _parsed(reading: LoadReading, robot: Element) -> "Robot":
    try:
        from urdf_parser_py.urdf import URDF  # noqa: PLC0415 -- it comes with an extra
    except ModuleNotFoundError:
        reading.undetermined(robot.span, URDF_MISSING, "install it: pip install 'stackdsl[urdf]'")
        raise UnreadableLoadError(reading.mistakes) from None
    try:
        with redirect_stderr(StringIO()):  # unknown elements were reported before
            return URDF.from_xml_string(xml_of(robot).strip())
    except Exception as error:
        reading.wrong(
            _span_of(robot, str(error)), f"urdf_parser_py reports: {' '.join(str(error).split())}", "correct it"
        )
        raise UnreadableLoadError(reading.mistakes) from error


def _span_of(robot: Element, message: str) -> Any:  # noqa: ANN401 -- a place
    """Return the position of the element whose path an error message of the parser contains."""
    for child in robot.children:
        if f"/{child.tag}[@name='{child.attributes.get('name')}']" in message:
            return child.span
    return robot.span


class _Links:
    """The links and joints of a robot, with their elements in the file."""

    def __init__(self, reading: LoadReading, element: Element, robot: "Robot") -> None:
        self._reading, self._robot = reading, robot
        self._elements = {child.attributes.get("name"): child for child in element.children if child.tag == "link"}
        self._joints = {child.attributes.get("name"): child for child in element.children if child.tag == "joint"}

    def bodies(self) -> Iterator[RobotBody]:
        """Yield the bodies that are bricks; report all others."""
        links = self._robot.links
        names = [link.name for link in links]
        for link in {link.name: link for link in links if names.count(link.name) > 1}.values():
            self._wrong(
                self._elements[link.name], f"two links have the name '{link.name}'", "give each a different name"
            )
        above: dict[str, Any] = {}
        for joint in self._robot.joints:
            element = self._joints[joint.name]
            if joint.child in above or joint.child not in names or joint.parent not in names:
                message = f"joint '{joint.name}' connects '{joint.parent}' to '{joint.child}', but a link is missing, "
                message += f"or '{joint.child}' already has a parent"
                self._wrong(element, message, "connect each link to one existing parent")
            above[joint.child] = joint
        self._reading.end()
        for link in links:
            if link.name not in above and len(links) > 1:
                self._check_world(link)
            elif (joint := above.get(link.name)) is not None and not self._floats(joint, above):
                continue
            elif (body := self._body(link, joint)) is not None:
                yield body

    def _check_world(self, link: "Link") -> None:
        if link.collisions:
            message = f"'{link.name}' is a root link with a shape, so it is fixed, but bricks move freely"
            self._unsupported(self._elements[link.name], link.name, message)

    def _floats(self, joint: Any, above: Mapping[str, Any]) -> bool:  # noqa: ANN401 -- the parser is untyped
        element = self._joints[joint.name]
        if joint.type != "floating":
            self._unsupported(element, joint.child, f"'{joint.child}' has a {joint.type} joint, but bricks move freely")
        elif joint.parent in above:
            message = f"the floating joint of '{joint.child}' has the parent '{joint.parent}' instead of the world"
            self._unsupported(element, joint.child, message)
        else:
            return True
        return False

    def _body(self, link: "Link", joint: Any) -> RobotBody | None:  # noqa: ANN401 -- the parser is untyped
        element = self._elements[link.name]
        if len(link.collisions) != 1:
            message = f"'{link.name}' has {len(link.collisions)} shapes, but a brick must have one"
            self._unsupported(element, link.name, message)
            return None
        if link.inertial is None or not link.inertial.mass:
            self._wrong(element, f"'{link.name}' has no mass", "add `inertial` with a `mass` to the link")
            return None
        (collision,) = link.collisions
        kind = type(collision.geometry).__name__.lower()
        corners, faces = self._mesh(element, collision.geometry) if kind == "mesh" else ((), ())
        if kind == "mesh" and not corners:
            return None
        shape_place, shape_turn = _frame(collision.origin)
        # Without an `origin`, the centre of mass is at the origin of the link.
        at = _frame(link.inertial.origin)[0] if link.inertial.origin is not None else ORIGIN
        place, turn = _frame(joint.origin if joint is not None else None)
        return RobotBody(
            name=brick_name(link.name, "link"),
            span=element.span,
            shape=kind,
            size=_three(collision.geometry.size) if kind == "box" else _curved_size(kind, collision.geometry),
            corners=corners,
            faces=faces,
            mass=Fraction(repr(float(link.inertial.mass))),
            place=place,
            turn=turn,
            shape_place=shape_place,
            shape_turn=shape_turn,
            centre_of_mass=at,
            friction=self._friction(element),
        )

    def _friction(self, element: Element) -> Fraction | None:
        """Return the friction of a link, if it gives one."""
        rough = next(iter(element.all("lateral_friction")), None)
        if rough is None:
            return None
        number = number_of(rough.attributes.get("value", "").strip())
        if number is None:
            self._wrong(rough, "the friction is not a number", 'write, for example, <lateral_friction value="0.5"/>')
        return number[0] if number is not None else None

    def _mesh(self, element: Element, geometry: Any) -> tuple[tuple[Vec3, ...], tuple[tuple[int, ...], ...]]:  # noqa: ANN401
        file = str(geometry.filename)
        kind = mesh_kind(file)
        if not (kind or file.lower().endswith(".obj")) or "://" in file:
            message = f"the mesh '{file}' is not an OBJ, STL or PLY file in the folder of this file"
            self._wrong(element, message, "save it as an .obj file")
            return (), ()
        data = self._reading.bytes_beside(file, element.span)
        if not data:
            return (), ()
        try:
            mesh = file_mesh(data.decode("latin-1") if kind else data.decode("utf-8-sig", "replace"), file)
        except InputError as error:
            self._wrong(element, error.message, error.hint)
            return (), ()
        scale = _three(geometry.scale) if geometry.scale is not None else (1.0, 1.0, 1.0)
        if not all(0.0 < factor < inf for factor in scale):
            self._wrong(element, f"the mesh '{file}' has an invalid scale of {scale}", "write positive numbers")
            return (), ()
        sx, sy, sz = scale
        return tuple((sx * x, sy * y, sz * z) for x, y, z in mesh.points), tuple(mesh.loops)

    def _unsupported(self, element: Element, name: str, message: str) -> None:
        self._reading.undetermined(element.span, message, f"to ignore it, write `ignore: ['{name}']`")

    def _wrong(self, element: Element, message: str, hint: str) -> None:
        self._reading.wrong(element.span, message, hint)


def _curved_size(kind: str, geometry: Any) -> Vec3 | None:  # noqa: ANN401 -- the parser is untyped
    if kind not in CURVED:
        return None
    return _around(kind, float(geometry.radius), float(getattr(geometry, "length", 0.0)))


def _three(parts: Any) -> Vec3:  # noqa: ANN401 -- the parser is untyped
    x, y, z = (float(part) for part in parts)
    return (x, y, z)


def _frame(origin: Any) -> tuple[Vec3, Quaternion]:  # noqa: ANN401 -- the parser is untyped
    """Return the position and the turn of an origin; rpy angles are about the fixed axes x, then y, then z."""
    from scipy.spatial.transform import Rotation  # noqa: PLC0415 -- as it is slow to import

    if origin is None:
        return ORIGIN, (0.0, 0.0, 0.0, 1.0)
    x, y, z, w = Rotation.from_euler("xyz", _three(origin.rpy or ORIGIN)).as_quat().tolist()
    return _three(origin.xyz or ORIGIN), (x, y, z, w)
