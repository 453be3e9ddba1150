"""What a snapshot was made with: versions, of which another one is a remark, and the engine, of which it is more."""

import sys
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, version

STAMPED = ("stackdsl",)  # distributions whose versions may move a snapshot, beside that of an engine
ENGINES = ("mujoco", "pybullet", "sapien")  # each by the name of its distribution, as it is imported


def current_stamp(engine: str, steps: int) -> dict[str, str]:
    """The versions that a snapshot is made with, of a run in which this engine took so many steps.

    What took none was decided by statics, whatever the engine. PyBullet is named all the same, as it always was.
    """
    named = (*STAMPED, engine) if steps or engine == "pybullet" else STAMPED
    return {"python": f"{sys.version_info.major}.{sys.version_info.minor}"} | {
        name: found for name in named if (found := _version(name))
    }


def _version(distribution: str) -> str:
    try:
        return version(distribution)
    except PackageNotFoundError:
        return ""


def differ_in_engine(expected: object, got: object) -> bool:
    """Whether two stamps name engines, and not the same: what such a run did after its first step is another story."""
    was, now = (_engines(stamp) for stamp in (expected, got))
    return bool(was and now and was != now)


def _engines(stamp: object) -> set[str]:
    return set(ENGINES) & _as_mapping(stamp).keys()


def stamp_note(expected: object, got: object) -> str:
    """What a snapshot was made with, where that is not what is in use now."""
    was, now = _as_mapping(expected), _as_mapping(got)
    changed = [name for name in sorted({*was, *now}) if was.get(name) != now.get(name)]
    made = ", ".join(f"{name} {was.get(name, 'none')} (now {now.get(name, 'none')})" for name in changed)
    return f"made with {made}" if made else ""


def _as_mapping(stamp: object) -> Mapping[str, object]:
    return stamp if isinstance(stamp, Mapping) else {}
