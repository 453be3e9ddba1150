"""A file that git could not merge is called so."""

from stackdsl.language.yaml.source import parse

HALF_MERGED = """\
scenario: shelf
build:
<<<<<<< HEAD
  - column: {levels: 3}
=======
  - column: {levels: 4}
>>>>>>> other
"""


def test_merge_conflict_is_reported() -> None:
    (mistake,) = parse(HALF_MERGED, "shelf.yaml").diagnostics
    assert (mistake.code, str(mistake.span)) == ("SD004", "shelf.yaml:3:1")
    assert "an unresolved merge conflict" in mistake.message
