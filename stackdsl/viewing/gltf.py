"""A recording as binary glTF: one node per brick, one mesh per shape, and one animation.

In glTF y is up and the unit is the metre, so a root node rotates the scene. A brick has size zero before it is placed
and after it is removed.
"""

from itertools import pairwise

import numpy as np
import pygltflib
from numpy.typing import NDArray

from stability.geometry.round_solid import RoundSolid
from stability.geometry.vectors import cross, subtract, unit
from stability.model import ConvexShape
from stackdsl.simulation.recording import Recording, Track
from stackdsl.viewing.bores import surface_of_pipe

Z_UP = [-(0.5**0.5), 0.0, 0.0, 0.5**0.5]  # rotates z to y
WOOD = [0.72, 0.52, 0.28, 1.0]  # linear red, green, blue, and opacity


class _Buffer:
    """The buffer of a file, with its accessors."""

    def __init__(self, gltf: pygltflib.GLTF2) -> None:
        self._gltf, self.data = gltf, bytearray()

    def add(self, values: NDArray[np.float64], form: str, target: int | None = None) -> int:
        """Append numbers as 32-bit floats; return the accessor."""
        data = np.ascontiguousarray(values, dtype="<f4")
        rows = data.reshape(len(data), -1)
        view = pygltflib.BufferView(buffer=0, byteOffset=len(self.data), byteLength=data.nbytes, target=target)
        self._gltf.bufferViews.append(view)
        accessor = pygltflib.Accessor(
            bufferView=len(self._gltf.bufferViews) - 1,
            componentType=pygltflib.FLOAT,
            count=len(data),
            type=form,
            min=rows.min(axis=0).tolist(),
            max=rows.max(axis=0).tolist(),
        )
        self._gltf.accessors.append(accessor)
        self.data += data.tobytes()
        return len(self._gltf.accessors) - 1


def glb(recording: Recording) -> bytes:
    """Return a recording as the bytes of a .glb file."""
    gltf = pygltflib.GLTF2(asset=pygltflib.Asset(generator="stackdsl"), scene=0)
    buffer = _Buffer(gltf)
    gltf.materials.append(
        pygltflib.Material(
            name="brick",
            pbrMetallicRoughness=pygltflib.PbrMetallicRoughness(
                baseColorFactor=WOOD, metallicFactor=0.0, roughnessFactor=0.8
            ),
        )
    )
    shapes = list(dict.fromkeys(brick.shape for brick in recording.bricks))
    for shape in shapes:
        gltf.meshes.append(_mesh(shape, buffer))
    animation = pygltflib.Animation(name="run")
    for number, brick in enumerate(recording.bricks):
        track = recording.track(brick.id)
        node = pygltflib.Node(
            name=brick.id,
            mesh=shapes.index(brick.shape),
            translation=track.positions[0].tolist(),
            rotation=track.orientations[0].tolist(),
        )
        gltf.nodes.append(node)
        _animate(animation, buffer, number, track, float(recording.removed_at[number]))
    bricks = len(gltf.nodes)
    gltf.nodes.append(pygltflib.Node(name="scene", rotation=Z_UP, children=list(range(bricks))))
    gltf.scenes.append(pygltflib.Scene(nodes=[bricks]))
    if animation.channels:
        gltf.animations.append(animation)
    gltf.buffers.append(pygltflib.Buffer(byteLength=len(buffer.data)))
    gltf.set_binary_blob(bytes(buffer.data))
    return b"".join(gltf.save_to_bytes())


def _mesh(shape: ConvexShape, buffer: _Buffer) -> pygltflib.Mesh:
    """Return the faces of a shape as triangle fans, each corner with the normal of its face."""
    points, loops = shape.corners, [(face.normal, face.corners) for face in shape.faces]
    if isinstance(shape, RoundSolid) and shape.bore:
        points, faces = surface_of_pipe(shape)
        loops = [
            (unit(cross(subtract(points[b], points[a]), subtract(points[c], points[b]))), (a, b, c, d))
            for a, b, c, d in faces
        ]
    corners, normals = [], []
    for normal, (first, *others) in loops:
        for second, third in pairwise(others):
            corners += [points[place] for place in (first, second, third)]
            normals += [normal] * 3
    attributes = pygltflib.Attributes(
        POSITION=buffer.add(np.array(corners), pygltflib.VEC3, pygltflib.ARRAY_BUFFER),
        NORMAL=buffer.add(np.array(normals), pygltflib.VEC3, pygltflib.ARRAY_BUFFER),
    )
    return pygltflib.Mesh(primitives=[pygltflib.Primitive(attributes=attributes, material=0)])


def _animate(animation: pygltflib.Animation, buffer: _Buffer, node: int, track: Track, removed_at: float) -> None:
    """Add the motion of a brick, with size zero while it is absent."""
    if len(track.times) > 1:
        orientations = track.orientations * _signs(track.orientations)[:, None]
        _channel(animation, buffer, node, "translation", track.times, track.positions)
        _channel(animation, buffer, node, "rotation", track.times, orientations)
    times, sizes = [], []
    if track.times[0] > 0.0:
        times, sizes = [0.0, float(track.times[0])], [0.0, 1.0]
    if np.isfinite(removed_at):
        times, sizes = [*(times or [0.0]), removed_at], [*(sizes or [1.0]), 0.0]
    if times:
        _channel(animation, buffer, node, "scale", np.array(times), np.array(sizes)[:, None] * np.ones(3), "STEP")


def _channel(  # noqa: PLR0913, PLR0917 -- the parts of a channel of glTF
    animation: pygltflib.Animation,
    buffer: _Buffer,
    node: int,
    path: str,
    times: NDArray[np.float64],
    values: NDArray[np.float64],
    between: str = "LINEAR",
) -> None:
    form = pygltflib.VEC4 if path == "rotation" else pygltflib.VEC3
    keys, output = buffer.add(times, pygltflib.SCALAR), buffer.add(values, form)
    animation.samplers.append(pygltflib.AnimationSampler(input=keys, output=output, interpolation=between))
    target = pygltflib.AnimationChannelTarget(node=node, path=path)
    animation.channels.append(pygltflib.AnimationChannel(sampler=len(animation.samplers) - 1, target=target))


def _signs(orientations: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return signs that make consecutive quaternions continuous."""
    flips = np.where((orientations[1:] * orientations[:-1]).sum(axis=1) < 0.0, -1.0, 1.0)
    signs: NDArray[np.float64] = np.concatenate(([1.0], np.cumprod(flips)))
    return signs
