"""Names of a part over those around it; nothing is copied, as either may be many, and parts are many too."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TypeVar

Value = TypeVar("Value")


@dataclass(frozen=True, slots=True)
class Inner(Mapping[str, Value]):
    """What names mean in a part: what they mean there, or else around it."""

    own: Mapping[str, Value]
    around: Mapping[str, Value]

    def __getitem__(self, name: str) -> Value:
        return self.own[name] if name in self.own else self.around[name]

    def __contains__(self, name: object) -> bool:
        return name in self.own or name in self.around

    def __iter__(self) -> Iterator[str]:
        yield from self.own
        yield from (name for name in self.around if name not in self.own)

    def __len__(self) -> int:
        return sum(1 for _ in self)
