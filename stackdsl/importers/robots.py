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
    refuse_odd_numbers,
    taken,
    written,
    xml_text,
)
from stackdsl.language.bricks import obj_mesh
from stackdsl.language.imports import Import
from stackdsl.language.quantities import MistakeError

if TYPE_CHECKING:
    from urdf_parser_py.urdf import Link, Robot

    from stability.engines.mujoco.compiled_scene import CompiledBody


# Bodies of MJCF and URDF: one shape each, somewhere in the body, which is somewhere in the scene.


ROUNDED: Final = 1e-9  # of a size: what of a centre of mass, or of a turn [deg], is rounding
DIGITS: Final = 12  # of a metre, or of a degree


@dataclass(frozen=True, slots=True)
class RobotBody:
    """A body of one shape, in SI units; turns are x, y, z, w."""

    name: str
    span: Span
    shape: str  # `box` or `mesh`, or else what it is
    size: Vec3 | None  # of a box
    corners: Sequence[Vec3]  # of a mesh, in the frame of the shape
    faces: Sequence[Sequence[int]]
    mass: Fraction
    place: Vec3  # of the body in the scene
    turn: Quaternion
    shape_place: Vec3  # of the shape in the body
    shape_turn: Quaternion
    centre_of_mass: Vec3  # in the body
    friction: Fraction | None = None  # Coulomb coefficient of its own


def brick_of(reading: LoadReading, body: RobotBody) -> ImportedBox | None:
    """A body as a brick; told and None if it is none."""
    hint = f"if it may be passed over, write ignore: ['{body.name}']"
    if body.shape not in {"box", "mesh"}:
        reading.open(body.span, f"'{body.name}' is a {body.shape}, and a brick is a box or a convex mesh", hint)
        return None
    if not _is_within_reason(reading, body):
        return None
    whole = Rotation.from_quat(body.turn) * Rotation.from_quat(body.shape_turn)
    centre = np.array(body.place) + Rotation.from_quat(body.turn).apply(body.shape_place)
    mass_at = np.array(body.place) + Rotation.from_quat(body.turn).apply(body.centre_of_mass)
    made = (_box if body.size else _solid)(reading, body, whole, centre, mass_at)
    return made and replace(made, friction=body.friction)


def _is_within_reason(reading: LoadReading, body: RobotBody) -> bool:
    """Whether its numbers are such as a brick may have; told if they are not."""
    if not 0 < body.mass <= HEAVIEST:
        reading.wrong(body.span, f"'{body.name}' has a mass of {float(body.mass):g} kg", "write more than zero")
        return False
    if not np.isfinite([*body.turn, *body.shape_turn]).all():
        reading.wrong(body.span, f"'{body.name}' is turned by what is no angle", "write numbers")
        return False
    lengths = np.array([body.place, body.shape_place, body.centre_of_mass, *body.corners])
    if not (np.abs(lengths) <= float(FURTHEST)).all():  # nor is what is no number
        message = f"'{body.name}' is more than 10 km away, or has its mass or a corner there"
        reading.wrong(body.span, message, "mend its numbers, or their unit")
        return False
    if body.friction is not None and not 0 <= body.friction <= ROUGHEST:
        message = f"'{body.name}' has a friction of {float(body.friction):g}"
        reading.wrong(body.span, message, f"write from 0 to {ROUGHEST}")
        return False
    return True


def _box(
    reading: LoadReading, body: RobotBody, whole: Rotation, centre: NDArray[np.float64], mass_at: NDArray[np.float64]
) -> ImportedBox | None:
    assert body.size is not None
    if not SHORTEST <= min(body.size) <= max(body.size) <= FURTHEST:
        reading.wrong(body.span, f"'{body.name}' has sides of {body.size} m", "mend them, or their unit")
        return None
    with warnings.catch_warnings():  # of angles that are not unique; these are as good as others
        warnings.simplefilter("ignore", UserWarning)
        turn = whole.as_euler("xyz", degrees=True)
    heavy = whole.inv().apply(mass_at - centre)
    off = bool(np.abs(heavy).max() > ROUNDED * max(body.size))
    heavy_at = _exact(heavy) if off else None
    return ImportedBox(
        body.name, _exact(body.size), _exact(centre), body.mass, body.span, _exact(turn), heavy_at=heavy_at
    )


def _solid(
    reading: LoadReading, body: RobotBody, whole: Rotation, centre: NDArray[np.float64], mass_at: NDArray[np.float64]
) -> ImportedBox | None:
    corners = [_exact(corner) for corner in centre + whole.apply(np.array(body.corners))]
    places, faces = merged(corners, body.faces)
    return solid_brick(
        reading, ImportedMesh(body.name, places, faces, body.span), mass=body.mass, heavy_at=_exact(mass_at)
    )


def _exact(parts: Sequence[float] | NDArray[np.float64]) -> Exact3:
    x, y, z = (Fraction(repr(round(float(part), DIGITS))) for part in parts)
    return (x, y, z)


# Scenes of MuJoCo, MJCF: bodies that are free to move, each of one box or one convex mesh, read by MuJoCo itself.
#
# What MuJoCo is given are those elements that say where bodies are, what they are shaped like and how heavy they are;
# files of meshes are looked for beside the scene. A level plane at a height of 0 is the ground. Where any shape says
# how rough it is, each has the friction that MuJoCo gives it, of which two that touch have the higher.


MJCF_MISSING: Final = "MJCF is read by MuJoCo, which is not installed"
_MJCF_TAKEN: Final[Mapping[str, frozenset[str]]] = {  # by what they are in
    "mujoco": frozenset({"compiler", "default", "asset", "worldbody"}),
    "default": frozenset({"default", "geom", "mesh", "joint"}),
    "asset": frozenset({"mesh"}),
    "worldbody": frozenset({"body", "geom"}),
    "body": frozenset({"body", "geom", "freejoint", "joint", "inertial"}),
}
# What is seen, measured or reckoned with, and says nothing of what stands.
_MJCF_HARMLESS: Final = frozenset(
    {"option", "size", "visual", "statistic", "material", "texture", "light", "camera", "site", "sensor", "keyframe"}
)
_LOOKS: Final = frozenset({"material", "rgba", "group"})  # attributes
FRICTION: Final = "friction"
_CONTACTS: Final = frozenset({"condim", "priority", "margin", "gap", "contype", "conaffinity"})
# Of a compiler: what is fixed to what it is in stays a body, which is told like any other that is not free.
_FUSES: Final = "fusestatic"
_FOLDERS: Final = ("meshdir", "assetdir", "texturedir")


def read_mjcf(reading: LoadReading, _: Import) -> ImportedLoad:
    """The free bodies of a scene, in its order. Raises UnreadableLoadError."""
    whole = xml_text(reading)
    if whole.tag != "mujoco":
        reading.wrong(whole.span, f"this is <{whole.tag}>, and no scene of MuJoCo", "name a file that is")
        reading.end()
    kept = taken(reading, whole, lambda parent, child: child.tag in _MJCF_TAKEN.get(parent.tag, ()), _MJCF_HARMLESS)
    kept = _without_ignored_of_mjcf(reading, kept)
    _leave_what_matters(reading, whole, kept)
    refuse_odd_numbers(reading, kept)
    _refuse_made_meshes(reading, kept)
    rough = _says_friction(reading, kept)
    files = _files(reading, kept)
    reading.end()
    world, *others = _compiled(reading, kept, files)
    grounds = list(_admitted_grounds(reading, kept, world))
    made = [brick_of(reading, body) for body in _bodies(reading, kept, others, rough)]
    reading.end()
    load = reading.load([brick for brick in made if brick is not None])
    return replace(load, surfaces=ImportedSurfaces(Rule.HIGHER, max(grounds, default=None))) if rough else load


def _leave_what_matters(reading: LoadReading, whole: Element, kept: Element) -> None:
    """Tell what changes how bodies touch or fall, and is not taken."""
    for element in kept.all("geom"):
        for key in sorted(_CONTACTS.intersection(element.attributes)):
            reading.leave(key, element.span, known=False)
    for option in whole.all("option"):
        if "gravity" in option.attributes:
            reading.leave("gravity", option.span, known=False)


def _refuse_made_meshes(reading: LoadReading, scene: Element) -> None:
    """Refuse the meshes that MuJoCo generates: a few digits can ask for all the memory there is."""
    for mesh in scene.all("mesh"):
        for key in sorted({"builtin", "plugin"}.intersection(mesh.attributes)):
            message = f"the mesh is made by MuJoCo, as `{key}` says, and such meshes are not taken"
            reading.wrong(mesh.span, message, "write its corners as `vertex`, or save it as a file")


def _says_friction(reading: LoadReading, scene: Element) -> bool:
    """Whether the file says how rough anything is, and its author does not pass it over."""
    said = [element for element in scene.all("geom") if FRICTION in element.attributes]
    if said and FRICTION in reading.ignored:
        reading.leave(FRICTION, said[0].span, known=False)
    return bool(said) and FRICTION not in reading.ignored


def _without_ignored_of_mjcf(reading: LoadReading, element: Element) -> Element:
    """Without the bodies and geoms that are to be ignored."""
    children = []
    for child in element.children:
        name = child.attributes.get("name", "")
        if child.tag in {"body", "geom"} and name in reading.ignored:
            reading.leave(name, child.span, known=False)
        else:
            children.append(_without_ignored_of_mjcf(reading, child))
    return Element(element.tag, element.attributes, element.span, element.line, children)


def _files(reading: LoadReading, scene: Element) -> dict[str, bytes]:
    """The files of meshes, by the names under which MuJoCo is given them."""
    folder = ""
    for compiler in scene.all("compiler"):
        folder = compiler.attributes.get("meshdir") or compiler.attributes.get("assetdir") or folder
    found: dict[str, bytes] = {}
    for mesh in scene.all("mesh"):
        if (file := mesh.attributes.get("file")) is not None:
            data = reading.file_beside("/".join(filter(None, (folder.rstrip("/"), file))), mesh.span)
            key = f"{len(found)}.{file.rpartition('.')[2]}"
            mesh.attributes.setdefault("name", re.split(r"[/\\]", file)[-1].rpartition(".")[0])
            mesh.attributes["file"] = key
            found[key] = data
    return found


def _compiled(reading: LoadReading, scene: Element, files: dict[str, bytes]) -> "list[CompiledBody]":
    try:
        from stability.engines.mujoco.compiled_scene import compiled_scene  # noqa: PLC0415 -- it comes with an extra
    except ModuleNotFoundError:
        reading.open(scene.span, MJCF_MISSING, "install it: pip install 'stackdsl[mujoco]'")
        raise UnreadableLoadError(reading.mistakes) from None

    def attributes(element: Element) -> dict[str, str]:
        ignored = (FRICTION,) if FRICTION in reading.ignored else ()
        left_out = (*_LOOKS, *_CONTACTS, *ignored, *((*_FOLDERS, _FUSES) if element.tag == "compiler" else ()))
        return {key: value for key, value in element.attributes.items() if key not in left_out}

    try:
        return compiled_scene(written(scene, attributes), files)
    except ValueError as error:
        said = " ".join(str(error).split())
        line = re.search(r"line (?:number=)?(\d+)", said, re.IGNORECASE)
        place = min(int(line[1]), len(reading.page.lines)) - 1 if line else scene.line - 1
        column = len(reading.page.lines[place]) - len(reading.page.lines[place].lstrip())
        span = reading.page.span(place, min(column, max(len(reading.page.lines[place]) - 1, 0)))
        reading.wrong(span, f"MuJoCo says: {said}", "mend the scene, until MuJoCo loads it")
        raise UnreadableLoadError(reading.mistakes) from error


def _bodies(reading: LoadReading, scene: Element, bodies: "list[CompiledBody]", rough: bool) -> Iterator[RobotBody]:
    """What is free to move, as MuJoCo has it, and how it rubs if that is asked; what is not free is told."""
    for number, (element, body) in enumerate(zip(scene.all("body"), bodies, strict=True), start=1):
        name = brick_name(element.attributes.get("name", ""), f"body-{number}")
        if body.joints != ("free",):
            held = "is joined to what it is in by a hinge or a slide" if body.joints else "is fixed"
            _not_taken(reading, element, f"'{name}' {held}, and bricks are free")
        elif len(body.geoms) != 1:
            _not_taken(reading, element, f"'{name}' is of {len(body.geoms)} shapes, and a brick is of one")
        elif not isfinite(body.mass + body.geoms[0].friction):
            reading.wrong(
                element.span, f"'{name}' comes to a mass or a friction that is not finite", "mend its numbers"
            )
        else:
            yield _body(element, name, body, rough)


def _not_taken(reading: LoadReading, element: Element, message: str) -> None:
    name = element.attributes.get("name")
    hint = f"if it may be passed over, write ignore: ['{name}']" if name else "give it a name, to ignore it by that"
    reading.open(element.span, message, hint)


def _admitted_grounds(reading: LoadReading, scene: Element, world: "CompiledBody") -> Iterator[Fraction]:
    """How rough the ground is: of what belongs to the world itself, it is what every scenario has."""
    within = scene.first("worldbody")
    elements = [child for child in within.children if child.tag == "geom"] if within is not None else []
    for element, geom in zip(elements, world.geoms, strict=True):
        off = max(abs(geom.turn[0]), abs(geom.turn[1]), abs(geom.place[2]))
        if geom.kind != "plane" or not off <= ROUNDED or not isfinite(geom.friction):
            message = "a shape of the world itself never moves, and there is ground at z = 0 only"
            _not_taken(reading, element, message)
        else:
            yield Fraction(repr(geom.friction))


def _body(element: Element, name: str, body: "CompiledBody", rough: bool) -> RobotBody:
    (geom,) = body.geoms
    x, y, z = geom.size
    return RobotBody(
        name=name,
        span=element.span,
        shape=geom.kind,
        size=(2.0 * x, 2.0 * y, 2.0 * z) if geom.kind == "box" else None,
        corners=geom.corners,
        faces=geom.faces,
        mass=Fraction(repr(body.mass)),
        place=body.place,
        turn=body.turn,
        shape_place=geom.place,
        shape_turn=geom.turn,
        centre_of_mass=body.centre_of_mass,
        friction=Fraction(repr(geom.friction)) if rough else None,
    )


# Robots and things of ROS, URDF: links that float, each of one box or one convex mesh, read by ROS's own parser.
#
# A file of one link is one brick, at the origin. Of several, bricks are those that a floating joint puts somewhere into
# the one link that is in no other and has no shape: the world.


URDF_MISSING: Final = "URDF is read by urdf_parser_py, which is not installed"
_URDF_TAKEN: Final[Mapping[str, frozenset[str]]] = {
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
_MAY_BE_IGNORED: Final = frozenset({"contact", "lateral_friction"})
NOWHERE: Final[Vec3] = (0.0, 0.0, 0.0)


def read_urdf(reading: LoadReading, _: Import) -> ImportedLoad:
    """The links that float, in the order of the file. Raises UnreadableLoadError."""
    whole = xml_text(reading)
    if whole.tag != "robot":
        reading.wrong(whole.span, f"this is <{whole.tag}>, and no URDF", "name a file that is")
        reading.end()
    passed_over = _MAY_BE_IGNORED & reading.ignored

    def is_taken(parent: Element, child: Element) -> bool:
        return child.tag in _URDF_TAKEN.get(parent.tag, ()) and child.tag not in passed_over

    kept = taken(reading, whole, is_taken, _URDF_HARMLESS)
    kept = _without_ignored_of_urdf(reading, kept)
    refuse_odd_numbers(reading, kept)
    reading.end()
    robot = _parsed(reading, kept)
    made = [brick_of(reading, body) for body in _Links(reading, kept, robot).bodies()]
    reading.end()
    load = reading.load([brick for brick in made if brick is not None])
    return (
        replace(load, surfaces=ImportedSurfaces(None)) if any(box.friction is not None for box in load.boxes) else load
    )


def _without_ignored_of_urdf(reading: LoadReading, robot: Element) -> Element:
    """Without the links that are to be ignored, and what joins these."""
    names = {link.attributes.get("name", "") for link in robot.children if link.tag == "link"} & reading.ignored
    children = []
    for child in robot.children:
        if child.tag == "link" and child.attributes.get("name") in names:
            reading.leave(child.attributes["name"], child.span, known=False)
        elif child.tag != "joint" or not names & {
            end.attributes.get("link", "") for end in child.children if end.tag == "child"
        }:
            children.append(child)
    return Element(robot.tag, robot.attributes, robot.span, robot.line, children)


def _parsed(reading: LoadReading, robot: Element) -> "Robot":
    try:
        from urdf_parser_py.urdf import URDF  # noqa: PLC0415 -- it comes with an extra
    except ModuleNotFoundError:
        reading.open(robot.span, URDF_MISSING, "install it: pip install 'stackdsl[urdf]'")
        raise UnreadableLoadError(reading.mistakes) from None
    try:
        with redirect_stderr(StringIO()):  # what it does not know has been told by now
            return URDF.from_xml_string(written(robot).strip())
    except Exception as error:
        reading.wrong(_span_of(robot, str(error)), f"urdf_parser_py says: {' '.join(str(error).split())}", "mend it")
        raise UnreadableLoadError(reading.mistakes) from error


def _span_of(robot: Element, message: str) -> Any:  # noqa: ANN401 -- a place
    """Where something is that the parser names by its way from the outermost element."""
    for child in robot.children:
        if f"/{child.tag}[@name='{child.attributes.get('name')}']" in message:
            return child.span
    return robot.span


class _Links:
    """The links of a robot, and where they are."""

    def __init__(self, reading: LoadReading, element: Element, robot: "Robot") -> None:
        self._reading, self._robot = reading, robot
        self._elements = {each.attributes.get("name"): each for each in element.children if each.tag == "link"}
        self._joints = {each.attributes.get("name"): each for each in element.children if each.tag == "joint"}

    def bodies(self) -> Iterator[RobotBody]:
        """The bodies that are bricks; all else is told."""
        links = self._robot.links
        names = [link.name for link in links]
        for link in {link.name: link for link in links if names.count(link.name) > 1}.values():
            self._tell(self._elements[link.name], f"there are two links '{link.name}'", "call them apart")
        above: dict[str, Any] = {}
        for joint in self._robot.joints:
            element = self._joints[joint.name]
            if joint.child in above or joint.child not in names or joint.parent not in names:
                message = f"joint '{joint.name}' joins '{joint.parent}' and '{joint.child}', of which one is not there"
                self._tell(element, message, "join each link once, to one that is there")
            above[joint.child] = joint
        self._reading.end()
        for link in links:
            if link.name not in above and len(links) > 1:
                self._admit_world(link)
            elif (joint := above.get(link.name)) is not None and not self._floats(joint, above):
                continue
            elif (body := self._body(link, joint)) is not None:
                yield body

    def _admit_world(self, link: "Link") -> None:
        if link.collisions:
            message = f"'{link.name}' is in no other link, and has a shape: it never moves, and bricks are free"
            self._ask(self._elements[link.name], link.name, message)

    def _floats(self, joint: Any, above: Mapping[str, Any]) -> bool:  # noqa: ANN401 -- the parser is untyped
        element = self._joints[joint.name]
        if joint.type != "floating":
            self._ask(element, joint.child, f"'{joint.child}' is held by a {joint.type} joint, and bricks are free")
        elif joint.parent in above:
            self._ask(element, joint.child, f"'{joint.child}' floats in '{joint.parent}', which is not the world")
        else:
            return True
        return False

    def _body(self, link: "Link", joint: Any) -> RobotBody | None:  # noqa: ANN401 -- the parser is untyped
        element = self._elements[link.name]
        if len(link.collisions) != 1:
            self._ask(element, link.name, f"'{link.name}' is of {len(link.collisions)} shapes, and a brick is of one")
            return None
        if link.inertial is None or not link.inertial.mass:
            self._tell(element, f"'{link.name}' has no mass", "write its `inertial`, with a `mass`")
            return None
        (collision,) = link.collisions
        kind = type(collision.geometry).__name__.lower()
        corners, faces = self._mesh(element, collision.geometry) if kind == "mesh" else ((), ())
        if kind == "mesh" and not corners:
            return None
        shape_place, shape_turn = _frame(collision.origin)
        # Without an `origin`, the mass is at that of the link.
        at = _frame(link.inertial.origin)[0] if link.inertial.origin is not None else NOWHERE
        place, turn = _frame(joint.origin if joint is not None else None)
        return RobotBody(
            name=brick_name(link.name, "link"),
            span=element.span,
            shape=kind,
            size=_three(collision.geometry.size) if kind == "box" else None,
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
        """What a link says of its own."""
        said = next(iter(element.all("lateral_friction")), None)
        if said is None:
            return None
        found = number_of(said.attributes.get("value", "").strip())
        if found is None:
            self._tell(said, "a friction that is no number", 'write it so: <lateral_friction value="0.5"/>')
        return found[0] if found is not None else None

    def _mesh(self, element: Element, geometry: Any) -> tuple[tuple[Vec3, ...], tuple[tuple[int, ...], ...]]:  # noqa: ANN401
        file = str(geometry.filename)
        if not file.lower().endswith(".obj") or "://" in file:
            self._tell(element, f"the mesh '{file}' is no OBJ file beside this one", "save it as OBJ, and name it so")
            return (), ()
        data = self._reading.file_beside(file, element.span)
        if not data:
            return (), ()
        try:
            mesh = obj_mesh(data.decode("utf-8-sig", "replace"), file)
        except MistakeError as error:
            self._tell(element, error.message, error.hint)
            return (), ()
        scale = _three(geometry.scale) if geometry.scale is not None else (1.0, 1.0, 1.0)
        if not all(0.0 < each < inf for each in scale):
            self._tell(element, f"the mesh '{file}' is scaled by {scale}", "write more than zero")
            return (), ()
        sx, sy, sz = scale
        return tuple((sx * x, sy * y, sz * z) for x, y, z in mesh.points), tuple(mesh.loops)

    def _ask(self, element: Element, name: str, message: str) -> None:
        self._reading.open(element.span, message, f"if it may be passed over, write ignore: ['{name}']")

    def _tell(self, element: Element, message: str, hint: str) -> None:
        self._reading.wrong(element.span, message, hint)


def _three(parts: Any) -> Vec3:  # noqa: ANN401 -- the parser is untyped
    x, y, z = (float(part) for part in parts)
    return (x, y, z)


def _frame(origin: Any) -> tuple[Vec3, Quaternion]:  # noqa: ANN401 -- the parser is untyped
    """Place, and turn: about x, then y, then z, fixed axes."""
    from scipy.spatial.transform import Rotation  # noqa: PLC0415 -- as it is slow to import

    if origin is None:
        return NOWHERE, (0.0, 0.0, 0.0, 1.0)
    x, y, z, w = Rotation.from_euler("xyz", _three(origin.rpy or NOWHERE)).as_quat().tolist()
    return _three(origin.xyz or NOWHERE), (x, y, z, w)
