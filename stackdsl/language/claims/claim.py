"""What an author may claim of what happened: what is expected, and what is known from outside."""

from typing import Annotated, Final, cast

from pydantic import BeforeValidator, Field, WithJsonSchema

from stackdsl.language import author_types as t
from stackdsl.language.author_models import Choice
from stackdsl.language.claims.claim_kind import ClaimKind


class Claim(Choice):
    """One statement about what happened, less the keys of the kinds of claims, which `schema` adds."""

    repeat: t.REPEAT = Field(None, description="variables that each repetition has its own values of")

    @property
    def stated(self) -> ClaimKind:
        """What is written under its key."""
        return cast("ClaimKind", getattr(self, self.kind))


def _listed(written: object) -> object:
    return [written] if isinstance(written, str) else written


_ONE: Final[t.JsonSchema] = {"enum": list(t.SYSTEMS)}
_ONE_OR_MORE: Final[t.JsonSchema] = {"anyOf": [_ONE, {"type": "array", "items": _ONE, "minItems": 1}]}


class Expectation(Claim):
    """What must come of the scenario."""

    system: Annotated[t.Systems, BeforeValidator(_listed), WithJsonSchema(_ONE_OR_MORE)] | None = Field(
        None, description="the system, or systems, that this is expected of; default: all"
    )


class Truth(Claim):
    """What is known from outside; compared and reported, but never a failure."""

    source: t.Text = Field(description="where it is known from")
    because: t.Text | None = Field(None, description="why it is so")
