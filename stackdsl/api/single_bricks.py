"""Bricks one by one, and the step of the build that sets them down."""

from collections.abc import Mapping, Sequence

from stackdsl.api.written import Written, written


def brick(
    *,
    at: Sequence[str],
    rotate: Sequence[str] | None = None,
    name: str | None = None,
    brick: str | Mapping[str, object] | None = None,
    level: int | None = None,
    drop: bool | None = None,
) -> Written:
    """One brick in any pose.

    at: [x, y, z] of its centre
    rotate: turn about x, then y, then z, the axes of the scene
    name: its name; default: by place, such as L3.2
    brick: what it is; default: the brick of the step, or else of the scenario
    level: its level; default: judged by its height
    drop: let go in the air, rather than set down
    """
    return written({"name": name, "at": at, "rotate": rotate, "brick": brick, "level": level, "drop": drop})


def bricks(
    each: Sequence[Written],
    *,
    when: str | None = None,
    after: str | None = None,
    name: str | None = None,
    brick: str | Mapping[str, object] | None = None,
    every: str | None = None,
) -> Written:
    """A step of the build that sets down bricks one by one; the keys are those of any step."""
    return written({"bricks": each, "at": when, "after": after, "name": name, "brick": brick, "every": every})
