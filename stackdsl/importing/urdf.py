"""Robots and things of ROS, URDF: links that float, each of one box or one convex mesh, read by ROS's own parser.

A file of one link is one brick, at the origin. Of several, bricks are those that a floating joint puts somewhere
into the one link that is in no other and has no shape: the world.
"""

from collections.abc import Iterator, Mapping
from contextlib import redirect_stderr
from dataclasses import replace
from fractions import Fraction
from io import StringIO
from math import inf
from typing import TYPE_CHECKING, Any, Final

from stability.model import Quaternion, Vec3
from stackdsl.importing.load import ImportedLoad, LoadReading, Surfaces, UnreadableLoadError
from stackdsl.importing.meshes import brick_name
from stackdsl.importing.numbers import number_of
from stackdsl.importing.placed_shapes import Body, brick_of
from stackdsl.importing.xml_text import Element, refuse_odd_numbers, taken, written, xml_text
from stackdsl.language.imports import Import
from stackdsl.language.mistakes import MistakeError
from stackdsl.language.obj_text import obj_mesh

if TYPE_CHECKING:
    from urdf_parser_py.urdf import Link, Robot

MISSING: Final = "URDF is read by urdf_parser_py, which is not installed"
_TAKEN: Final[Mapping[str, frozenset[str]]] = {
    "robot": frozenset({"link", "joint"}),
    "link": frozenset({"inertial", "collision", "contact"}),
    "contact": frozenset({"lateral_friction"}),
    "inertial": frozenset({"origin", "mass"}),
    "collision": frozenset({"origin", "geometry"}),
    "geometry": frozenset({"box", "mesh", "cylinder", "sphere", "capsule"}),
    "joint": frozenset({"parent", "child", "origin", "axis", "limit"}),
}
_HARMLESS: Final = frozenset(
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
        return child.tag in _TAKEN.get(parent.tag, ()) and child.tag not in passed_over

    kept = taken(reading, whole, is_taken, _HARMLESS)
    kept = _without_ignored(reading, kept)
    refuse_odd_numbers(reading, kept)
    reading.end()
    robot = _parsed(reading, kept)
    made = [brick_of(reading, body) for body in _Links(reading, kept, robot).bodies()]
    reading.end()
    load = reading.load([brick for brick in made if brick is not None])
    return replace(load, surfaces=Surfaces(None)) if any(box.friction is not None for box in load.boxes) else load


def _without_ignored(reading: LoadReading, robot: Element) -> Element:
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
        reading.open(robot.span, MISSING, "install it: pip install 'stackdsl[urdf]'")
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

    def bodies(self) -> Iterator[Body]:
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

    def _body(self, link: "Link", joint: Any) -> Body | None:  # noqa: ANN401 -- the parser is untyped
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
        return Body(
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
