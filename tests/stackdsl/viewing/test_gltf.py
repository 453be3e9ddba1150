"""A run as glTF, opened by another library than wrote it, and its keyframes read by hand from the format."""

import json
import struct
from io import BytesIO
from typing import Any

import numpy as np
import pytest

from stability.geometry.vectors import rotate
from stackdsl.viewing.run_view import RunView
from tests.stackdsl.viewing.views import SLANT_TOWER, views_of

pytest.importorskip("pygltflib")


@pytest.fixture(scope="module")
def tower() -> RunView:
    (found,) = views_of(SLANT_TOWER)
    return found


@pytest.fixture(scope="module")
def data(tower: RunView) -> bytes:
    from stackdsl.viewing.gltf import glb  # noqa: PLC0415 -- an extra

    return glb(tower.recording)


def parts(data: bytes) -> tuple[dict[str, Any], bytes]:
    """The JSON and the bytes of a .glb, by the format's own headers."""
    magic, version, length = struct.unpack_from("<4sII", data)
    assert (magic, version, length) == (b"glTF", 2, len(data))
    size, kind = struct.unpack_from("<I4s", data, 12)
    assert kind == b"JSON"
    return json.loads(data[20 : 20 + size]), data[20 + size + 8 :]


def values(told: dict[str, Any], rest: bytes, number: int) -> np.ndarray[Any, np.dtype[np.float32]]:
    accessor = told["accessors"][number]
    width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor["type"]]
    begin = told["bufferViews"][accessor["bufferView"]].get("byteOffset", 0)
    return np.frombuffer(rest, "<f4", accessor["count"] * width, begin).reshape(-1, width)


def test_another_library_finds_every_brick_where_it_came(tower: RunView, data: bytes) -> None:
    trimesh = pytest.importorskip("trimesh")
    scene = trimesh.load(BytesIO(data), file_type="glb")
    assert {*tower.recording.names} <= set(scene.graph.nodes)
    for brick in tower.recording.bricks:
        transform, geometry = scene.graph[brick.id]
        mesh = scene.geometry[geometry]
        placed = tower.trace.tracks[brick.id].placed
        x, y, z = placed.position_W
        assert transform[:3, 3] == pytest.approx((x, z, -y), abs=1e-6)  # glTF has y up
        mesh.merge_vertices(merge_norm=True)  # each face has corners of its own, for its normal
        assert mesh.is_watertight
        assert mesh.volume == pytest.approx(brick.shape.volume, rel=1e-5)
        along = rotate(placed.orientation, (1.0, 0.0, 0.0))
        assert transform[:3, 0] == pytest.approx((along[0], along[2], -along[1]), abs=1e-6)


def test_each_brick_has_the_keyframes_that_were_recorded(tower: RunView, data: bytes) -> None:
    told, rest = parts(data)
    (animation,) = told["animations"]
    paths = {
        (channel["target"]["node"], channel["target"]["path"]): channel["sampler"] for channel in animation["channels"]
    }
    for number, name in enumerate(tower.recording.names):
        track = tower.recording.track(name)
        moving = len(track.times) > 1
        assert ((number, "translation") in paths) == moving
        if moving:
            sampler = animation["samplers"][paths[number, "translation"]]
            assert values(told, rest, sampler["input"])[:, 0] == pytest.approx(track.times, abs=1e-5)
            assert values(told, rest, sampler["output"]) == pytest.approx(track.positions, abs=1e-6)
        if track.times[0] > 0.0:  # it comes later, and has no size until then
            sizes = animation["samplers"][paths[number, "scale"]]
            assert sizes["interpolation"] == "STEP"
            assert values(told, rest, sizes["output"]).tolist() == [[0.0] * 3, [1.0] * 3]
