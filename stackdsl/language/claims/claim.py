"""Expectations and truths: claims about the outcome of a run."""

from typing import Annotated, cast

from pydantic import BeforeValidator, Field, WithJsonSchema

from stackdsl.language import value_types as t
from stackdsl.language.claims.claim_kind import ClaimKind
from stackdsl.language.model_base import ExactlyOneKey


class Claim(ExactlyOneKey):
    """One statement about the outcome. The keys of the kinds of claims are added by `schema`."""

    repeat: t.REPEAT = Field(None, description="variables and their values; the item is repeated for each combination")

    @property
    def content(self) -> ClaimKind:
        """Return the value of the key of its kind."""
        return cast("ClaimKind", getattr(self, self.kind))


class Expectation(Claim):
    """An expected outcome, which fails the scenario if it is not met."""

    system: Annotated[t.Systems, BeforeValidator(t.listed), WithJsonSchema(t.ONE_OR_MORE_SYSTEMS)] | None = Field(
        None, description="system or systems to which this expectation applies; default: all"
    )


class Truth(Claim):
    """An outcome known from another source. It is compared and reported, but never fails the scenario."""

    source: t.Text = Field(description="source of the outcome, such as a publication")
    because: t.Text | None = Field(None, description="explanation of the outcome")
