"""Scenes of MuJoCo, MJCF: bodies that are free to move, each of one box or one convex mesh, read by MuJoCo itself.

What MuJoCo is given are those elements that say where bodies are, what they are shaped like and how heavy they are;
files of meshes are looked for beside the scene. A level plane at a height of 0 is the ground. Where any shape says how
rough it is, each has the friction that MuJoCo gives it, of which two that touch have the higher.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from fractions import Fraction
from math import isfinite
from typing import TYPE_CHECKING, Final

from stability.friction_law import Rule
from stackdsl.importing.load import ImportedLoad, LoadReading, Surfaces, UnreadableLoadError
from stackdsl.importing.meshes import brick_name
from stackdsl.importing.placed_shapes import ROUNDED, Body, brick_of
from stackdsl.importing.xml_text import Element, refuse_odd_numbers, taken, written, xml_text
from stackdsl.language.imports import Import

if TYPE_CHECKING:
    from stability.engines.mujoco.compiled_scene import CompiledBody

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
    kept = taken(reading, whole, lambda parent, child: child.tag in _TAKEN.get(parent.tag, ()), _HARMLESS)
    kept = _without_ignored(reading, kept)
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
    return replace(load, surfaces=Surfaces(Rule.HIGHER, max(grounds, default=None))) if rough else load


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


def _compiled(reading: LoadReading, scene: Element, files: dict[str, bytes]) -> "list[CompiledBody]":
    try:
        from stability.engines.mujoco.compiled_scene import compiled_scene  # noqa: PLC0415 -- it comes with an extra
    except ModuleNotFoundError:
        reading.open(scene.span, MISSING, "install it: pip install 'stackdsl[mujoco]'")
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


def _bodies(reading: LoadReading, scene: Element, bodies: "list[CompiledBody]", rough: bool) -> Iterator[Body]:
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


def _body(element: Element, name: str, body: "CompiledBody", rough: bool) -> Body:
    (geom,) = body.geoms
    x, y, z = geom.size
    return Body(
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
