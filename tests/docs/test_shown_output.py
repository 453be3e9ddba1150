"""What counts as the same as what a page shows."""

import pytest

from tests.docs.shown_output import differences

PRINTED = "one 1\ntwo 2\nthree 3\n"


@pytest.mark.parametrize(
    "shown", ["one 1\ntwo 2\nthree 3", "one ~\n...\nthree 3", "...\ntwo   2\n...", "one ...\ntwo 2\nthree ..."]
)
def test_lines_may_be_left_out_where_the_page_says_so(shown: str) -> None:
    assert differences(shown, PRINTED) == []


@pytest.mark.parametrize("shown", ["one 1\nthree 3", "one 1\ntwo 2", "one\n...", "...\ntwo 3\n...", "two 2\n..."])
def test_anything_else_is_told(shown: str) -> None:
    assert differences(shown, PRINTED)
