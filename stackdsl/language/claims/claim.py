"""What an author may claim of what happened: what is expected, and what is known from outside."""

from typing import Annotated, cast

from pydantic import BeforeValidator, Field, WithJsonSchema

from stackdsl.language import value_types as t
from stackdsl.language.claims.claim_kind import ClaimKind
from stackdsl.language.model_base import ExactlyOneKey


class Claim(ExactlyOneKey):
    """One statement about what happened, less the keys of the kinds of claims, which `schema` adds."""

    repeat: t.REPEAT = Field(None, description="variables that each repetition has its own values of")

    @property
    def stated(self) -> ClaimKind:
        """What is written under its key."""
        return cast("ClaimKind", getattr(self, self.kind))


class Expectation(Claim):
    """What must come of the scenario."""

    system: Annotated[t.Systems, BeforeValidator(t.listed), WithJsonSchema(t.ONE_OR_MORE_SYSTEMS)] | None = Field(
        None, description="the system, or systems, that this is expected of; default: all"
    )


class Truth(Claim):
    """What is known from outside; compared and reported, but never a failure."""

    source: t.Text = Field(description="where it is known from")
    because: t.Text | None = Field(None, description="why it is so")
