"""Which bricks a claim or an impact names: all values whose type says that they do."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import get_args

from pydantic import BaseModel

from stability.model import BodyId
from stackdsl.reading.source import Path


def _itself(value: object) -> BodyId | None:
    return value if isinstance(value, str) else None


@dataclass(frozen=True, slots=True)
class NamesBody:
    """Marks a type whose values name a brick, as `Annotated[..., NamesBody()]`."""

    or_plane: bool = False  # or else the ground or a wall
    read: Callable[[object], BodyId | None] = _itself  # the name in a value, if there is one


@dataclass(frozen=True, slots=True)
class Named:
    """A name, and where it stands in the file."""

    path: Path
    name: BodyId
    or_plane: bool  # whether the ground or a wall may be meant as well


def named_in(model: BaseModel, path: Path = ()) -> Iterator[Named]:
    """The names in a mapping that stands at a path, in the order of its keys."""
    markers = _markers(type(model))
    for key, field in type(model).model_fields.items():
        value, place = getattr(model, key), (*path, field.alias or key)
        if isinstance(value, BaseModel):
            yield from named_in(value, place)
        elif key in markers and isinstance(value, tuple):
            yield from (name for index, each in enumerate(value) for name in _name(each, markers[key], (*place, index)))
        elif key in markers:
            yield from _name(value, markers[key], place)


def _name(value: object, marker: NamesBody, path: Path) -> Iterator[Named]:
    name = marker.read(value)
    if name is not None:
        yield Named(path, name, marker.or_plane)


@cache
def _markers(model: type[BaseModel]) -> Mapping[str, NamesBody]:
    found = {key: _marker_in((*field.metadata, field.annotation)) for key, field in model.model_fields.items()}
    return {key: marker for key, marker in found.items() if marker is not None}


def _marker_in(parts: tuple[object, ...]) -> NamesBody | None:
    for part in parts:
        found = part if isinstance(part, NamesBody) else _marker_in(get_args(part))
        if found is not None:
            return found
    return None
