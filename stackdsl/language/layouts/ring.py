r"""The ring of posts with lintels on them, as at Stonehenge.

Posts stand on end with their flat sides to the axis, at angles of 2 a, and each lintel lies on two of them, with its
centre line through the middles of both. From the middle of a post of width w and thickness t, the centre line continues
for e = min(w / 2 / cos a, t / 2 / sin a) to the side or the face of the post. With posts at a distance R from the axis,
each end of a lintel of length L overlaps its post by

    o = L / 2 - (R sin a - e)

of the centre line, so it cannot tip sideways either. Neighbouring lintels do not touch for
L / 2 <= (R cos a - w / 2) tan a, which is o <= e - w / 2 tan a.
"""

from math import cos, pi, sin, tan
from typing import Annotated, ClassVar

from pydantic import Field

from stability.model import Vec3
from stackdsl.language.layouts.registry import BrickSpec, LayoutParams, Specs, layout
from stackdsl.language.model_base import default
from stackdsl.language.quantities import InputError
from stackdsl.language.value_types import MAX_BRICKS, ShareOfLimit


class RingParams(LayoutParams):
    """Posts in a circle, with lintels on them."""

    posts: Annotated[int, Field(strict=True, ge=3, le=MAX_BRICKS // 2)] = Field(
        description="number of posts, equal to the number of lintels"
    )
    overlap: ShareOfLimit = default(
        "80 %", "overlap of lintels and posts, as a fraction of the overlap at which lintels touch"
    )

    count: ClassVar[str] = "posts"

    @property
    def bricks_at_most(self) -> int:
        return 2 * self.posts


@layout("ring", RingParams)
def ring(params: RingParams, size: Vec3) -> Specs:
    """Posts on end in a circle, and lintels that each lie on two of them, with half of their weight on each.

    The first post is towards +x, and they are counted from there towards +y; lintel n lies on posts n and n + 1.
    Without one of its posts a lintel falls, since its middle is over the opening.
    """
    length, width, thickness = size
    a = pi / params.posts
    if not 0.0 < params.overlap < 1.0:
        problem = "misses the posts" if params.overlap <= 0.0 else "overlaps its neighbours"
        hint = "write an overlap greater than 0 % and less than 100 %"
        raise InputError("SD104", f"with this overlap every lintel {problem}", hint)
    on = min(0.5 * width / cos(a), 0.5 * thickness / sin(a))
    most = on - 0.5 * width * tan(a)
    if most <= 0.0:
        message = f"with {params.posts} posts, lintels that are long enough to reach the posts overlap each other"
        raise InputError("SD104", message, "use more posts, or thicker or narrower bricks")
    radius = (0.5 * length - params.overlap * most + on) / sin(a)
    across = radius * cos(a)  # from the axis to the middle of a lintel
    bearings = [2.0 * number * a for number in range(params.posts)]
    posts = [BrickSpec(1, _at(radius, b, 0.5 * length), yaw=b, lean=0.5 * pi) for b in bearings]
    top = length + 0.5 * thickness
    lintels = [BrickSpec(2, _at(across, b + a, top), yaw=b + a + 0.5 * pi) for b in bearings]
    return (*posts, *lintels)


def _at(radius: float, bearing: float, z: float) -> Vec3:
    return (radius * cos(bearing), radius * sin(bearing), z)
