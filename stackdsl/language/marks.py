"""Scenarios that are not played, or that are known to come out wrong, each with the reason."""

from importlib.util import find_spec
from typing import Annotated, ClassVar, Literal

from pydantic import AfterValidator, BeforeValidator, Field, WithJsonSchema

from stackdsl.language import author_types as t
from stackdsl.language.author_models import Shorthand

Package = Literal["mujoco", "sapien"]  # that formats are read with, and engines are of


def _in_one_line(text: str) -> str:
    return " ".join(text.split())


class Mark(Shorthand):
    """Why, and on which systems."""

    reason: Annotated[t.Text, AfterValidator(_in_one_line)] = Field(description="why")
    system: Annotated[t.Systems, BeforeValidator(t.listed), WithJsonSchema(t.ONE_OR_MORE_SYSTEMS)] | None = Field(
        None, description="the system, or systems, that this is said of; default: all"
    )

    scalar_key: ClassVar[str] = "reason"

    def is_of(self, system: str) -> bool:
        """Whether it is said of a system."""
        return self.system is None or system in self.system


class Skip(Mark):
    """Not played."""

    without: Package | None = Field(None, description="played all the same wherever this Python package is installed")

    def is_of(self, system: str) -> bool:
        """Whether it is said of a system, here."""
        return Mark.is_of(self, system) and (self.without is None or not is_installed(self.without))


def is_installed(package: str) -> bool:
    """Whether a Python package can be imported here."""
    return find_spec(package) is not None


class Xfail(Mark):
    """Played, and known to fail its expectations: for now, and for a reason."""

    strict: t.Flag = Field(True, description="whether it fails the check that all expectations are met after all")
