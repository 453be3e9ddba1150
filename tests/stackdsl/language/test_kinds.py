"""Registries of layouts, claims and impacts: the order of the keys does not depend on the order of registration."""

from itertools import permutations

import pytest

from stackdsl.language.model_base import Kinds


@pytest.mark.parametrize("registered", list(permutations(["tilts", "stands", "falls", "bends"])))
def test_kinds_are_listed_in_the_given_order_then_by_name(registered: tuple[str, ...]) -> None:
    kinds = Kinds[int]("claim", "stands", "falls")
    for key in registered:
        kinds.register(key, 0)
    assert list(kinds) == ["stands", "falls", "bends", "tilts"]
