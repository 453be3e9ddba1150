"""Scenes of MuJoCo, MJCF: bodies that are free to move, each of one box or one convex mesh, read by MuJoCo itself.

What MuJoCo is given are those elements that say where bodies are, what they are shaped like and how heavy they are;
files of meshes are looked for beside the scene. A level plane at a height of 0 is the ground.
"""

import re
from collections.abc import Iterator, Mapping
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Final

from stability.model import Quaternion, Vec3
from stackdsl.importing.load import ImportedLoad, LoadReading, UnreadableLoadError
from stackdsl.importing.meshes import brick_name
from stackdsl.importing.placed_shapes import Body, brick_of
from stackdsl.importing.xml_text import Element, taken, written, xml_text
from stackdsl.language.imports import Import

if TYPE_CHECKING:
    import mujoco

MISSING: Final = "MJCF is read by MuJoCo, which is not installed"
_TAKEN: Final[Mapping[str, frozenset[str]]] = {  # by what they are in
    "mujoco": frozenset({"compiler", "default", "asset", "worldbody"}),
    "default": frozenset({"default", "geom", "mesh", "joint"}),
    "asset": frozenset({"mesh"}),
    "worldbody": frozenset({"body", "geom"}),
    "body": frozenset({"body", "geom", "freejoint", "joint", "inertial"}),
}
# What is seen, measured or reckoned with, and says nothing of what stands.
_HARMLESS: Final = frozenset(
    {"option", "size", "visual", "statistic", "material", "texture", "light", "camera", "site", "sensor", "keyframe"}
)
_LOOKS: Final = frozenset({"material", "rgba", "group"})  # attributes
_FRICTIONS: Final = frozenset({"friction", "condim", "priority", "margin", "gap", "contype", "conaffinity"})
_FOLDERS: Final = ("meshdir", "assetdir", "texturedir")
BOX, PLANE, MESH = "BOX", "PLANE", "MESH"


def read_mjcf(reading: LoadReading, _: Import) -> ImportedLoad:
    """The free bodies of a scene, in its order. Raises UnreadableLoadError."""
    whole = xml_text(reading)
    if whole.tag != "mujoco":
        reading.wrong(whole.span, f"this is <{whole.tag}>, and no scene of MuJoCo", "name a file that is")
        reading.end()
    kept = taken(reading, whole, lambda parent, child: child.tag in _TAKEN.get(parent.tag, ()), _HARMLESS)
    kept = _without_ignored(reading, kept)
    for element in kept.all("geom"):
        for key in sorted(_FRICTIONS.intersection(element.attributes)):
            reading.leave(key, element.span, known=False)
    for option in whole.all("option"):
        if "gravity" in option.attributes:
            reading.leave("gravity", option.span, known=False)
    files = _files(reading, kept)
    reading.end()
    model = _compiled(reading, kept, files)
    made = [brick_of(reading, body) for body in _bodies(reading, kept, model)]
    reading.end()
    return reading.load([brick for brick in made if brick is not None])


def _without_ignored(reading: LoadReading, element: Element) -> Element:
    """Without the bodies and geoms that are to be ignored."""
    children = []
    for child in element.children:
        name = child.attributes.get("name", "")
        if child.tag in {"body", "geom"} and name in reading.ignored:
            reading.leave(name, child.span, known=False)
        else:
            children.append(_without_ignored(reading, child))
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


def _compiled(reading: LoadReading, scene: Element, files: dict[str, bytes]) -> "mujoco.MjModel":
    try:
        import mujoco  # noqa: PLC0415 -- it comes with an extra
    except ModuleNotFoundError:
        reading.open(scene.span, MISSING, "install it: pip install 'stackdsl[mujoco]'")
        raise UnreadableLoadError(reading.mistakes) from None

    def attributes(element: Element) -> dict[str, str]:
        left_out = (*_LOOKS, *_FRICTIONS, *(_FOLDERS if element.tag == "compiler" else ()))
        return {key: value for key, value in element.attributes.items() if key not in left_out}

    try:
        return mujoco.MjSpec.from_string(written(scene, attributes), assets=files).compile()
    except ValueError as error:
        said = " ".join(str(error).split())
        line = re.search(r"line (?:number=)?(\d+)", said, re.IGNORECASE)
        place = min(int(line[1]), len(reading.page.lines)) - 1 if line else scene.line - 1
        column = len(reading.page.lines[place]) - len(reading.page.lines[place].lstrip())
        span = reading.page.span(place, min(column, max(len(reading.page.lines[place]) - 1, 0)))
        reading.wrong(span, f"MuJoCo says: {said}", "mend the scene, until MuJoCo loads it")
        raise UnreadableLoadError(reading.mistakes) from error


def _bodies(reading: LoadReading, scene: Element, model: "mujoco.MjModel") -> Iterator[Body]:
    """What is free to move, as MuJoCo has it; what is not is told."""
    elements = list(scene.all("body"))
    for geom in range(model.body_geomnum[0]):
        _admit_ground(reading, scene, model, geom)
    for number, element in enumerate(elements, start=1):
        name = brick_name(element.attributes.get("name", ""), f"body-{number}")
        joints = [model.jnt_type[model.body_jntadr[number] + n] for n in range(model.body_jntnum[number])]
        if joints != [0]:  # mjJNT_FREE
            message = f"'{name}' is joined to what it is in by a hinge or a slide" if joints else f"'{name}' is fixed"
            _not_taken(reading, element, f"{message}, and bricks are free")
        elif model.body_geomnum[number] != 1:
            _not_taken(reading, element, f"'{name}' is of {model.body_geomnum[number]} shapes, and a brick is of one")
        else:
            yield _body(element, name, model, number)


def _not_taken(reading: LoadReading, element: Element, message: str) -> None:
    name = element.attributes.get("name")
    hint = f"if it may be passed over, write ignore: ['{name}']" if name else "give it a name, to ignore it by that"
    reading.open(element.span, message, hint)


def _admit_ground(reading: LoadReading, scene: Element, model: "mujoco.MjModel", geom: int) -> None:
    """Of what belongs to the world itself, the ground is what every scenario has."""
    world = scene.first("worldbody")
    geoms = [child for child in world.children if child.tag == "geom"] if world is not None else []
    x, y, _, _ = _turned(model.geom_quat[geom])
    level = abs(x) < 1e-9 and abs(y) < 1e-9 and abs(model.geom_pos[geom][2]) < 1e-9  # noqa: PLR2004 -- rounding
    if not (level and _kind(model, geom) == PLANE):
        _not_taken(reading, geoms[geom], "a shape of the world itself never moves, and there is ground at z = 0 only")


def _kind(model: "mujoco.MjModel", geom: int) -> str:
    import mujoco  # noqa: PLC0415 -- it is there, or there would be no model

    return str(mujoco.mjtGeom(model.geom_type[geom]).name).removeprefix("mjGEOM_")


def _turned(quaternion: Any) -> Quaternion:  # noqa: ANN401 -- an array
    w, x, y, z = (float(part) for part in quaternion)
    return (x, y, z, w)


def _body(element: Element, name: str, model: "mujoco.MjModel", number: int) -> Body:
    geom = int(model.body_geomadr[number])
    kind = _kind(model, geom)
    corners, faces = _mesh(model, int(model.geom_dataid[geom])) if kind == MESH else ((), ())
    x, y, z = _three(model.geom_size[geom])
    return Body(
        name=name,
        span=element.span,
        shape=kind.lower(),
        size=(2.0 * x, 2.0 * y, 2.0 * z) if kind == BOX else None,
        corners=corners,
        faces=faces,
        mass=Fraction(repr(float(model.body_mass[number]))),
        place=_three(model.body_pos[number]),
        turn=_turned(model.body_quat[number]),
        shape_place=_three(model.geom_pos[geom]),
        shape_turn=_turned(model.geom_quat[geom]),
        centre_of_mass=_three(model.body_ipos[number]),
    )


def _mesh(model: "mujoco.MjModel", mesh: int) -> tuple[tuple[Vec3, ...], tuple[tuple[int, ...], ...]]:
    """Corners and faces, as MuJoCo has them: about the centre of mass, along the principal axes."""
    first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
    corners = tuple(_three(corner) for corner in model.mesh_vert[first : first + count])
    first, count = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
    return corners, tuple(tuple(map(int, face)) for face in model.mesh_face[first : first + count])


def _three(parts: Any) -> Vec3:  # noqa: ANN401 -- an array
    x, y, z = (float(part) for part in parts)
    return (x, y, z)
