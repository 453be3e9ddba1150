"""Syntax errors in plain words: what either parser says of malformed YAML, told as cause and remedy, at its place."""

import re
from typing import Final

import yaml

from stackdsl.diagnostics import Diagnostic, Page

UNKNOWN_ESCAPE: Final = (
    "an escape that YAML does not know",
    "double the backslash, or put the text in single quotes",
)
# What either parser says -> message and hint. In the message, @ is the character blamed, # the line of the opening.
SYNTAX: Final = (
    ("mapping values", "a ':' where no key can stand", "quote the text that holds it, or check the indentation"),
    ("any token|parsing a block node", "a value cannot begin with '@'", "quote it"),
    ("quoted scalar.*(end of stream|document)", "a quoted text is not closed", "add the missing quote"),
    ("quoted scalar", *UNKNOWN_ESCAPE),
    ("simple key", "a key without its ':'", "write `key: value`, or check the indentation"),
    ("a block mapping:", "neither a key of the mapping from line # nor its end", "check indentation and quotes"),
    (
        "a block collection:",
        "neither an item of the list from line # nor its end",
        "begin each item with '- ', or indent as above",
    ),
    ("a flow sequence:", "the list that opens in line # lacks a ',' or ']'", "close it; in brackets, quote ${...}"),
    ("a flow mapping:", "the mapping that opens in line # lacks a ',' or '}'", "close it; in braces, quote ${...}"),
    ("a flow node:", "a value or a closing bracket is missing", "write it, or quote text that holds , [ ] { or }"),
    ("a block scalar", "'@' begins a text block, and what follows is none", 'quote a comparison: ">= 20"'),
    ("mapping keys", "a '?' that begins no key", "quote it"),
    ("unexpected ':'", "a ':' in brackets that ends no key", "quote the text that holds it"),
    ("sequence entries", "a list cannot begin here", "begin it on the next line, or quote the text"),
    ("an alias|an anchor", "an alias or anchor without a name", "quote text that begins with * or &"),
    ("expected '?<document start>", "text after the end of a document", "begin the next scenario with '---'"),
)
BLAMES_OPENING = re.compile(
    "quoted scalar.*(end of stream|document)|simple key|a block scalar|a directive|an alias|an anchor|a tag:"
)


MERGE_MARKER: Final = re.compile(r"<{7}(?: |$)")  # as git leaves it


def syntax_error(page: Page, error: yaml.MarkedYAMLError) -> Diagnostic:
    """What is wrong with a text that is no YAML."""
    marked = next((number for number, line in enumerate(page.lines) if MERGE_MARKER.match(line)), None)
    if marked is not None:
        message = "the file holds two versions, with the markers of a merge from here on"
        hint = "keep what is meant of both, and delete the lines that begin with <<<<<<<, ======= and >>>>>>>"
        return Diagnostic("SD004", page.span(marked, 0), message, hint)
    said = f"{error.context or ''}: {error.problem or ''}"
    line, column = _blamed(page, error, said)
    span = page.span(line, column)
    if re.search("directive(?!>)|incompatible YAML", said):
        return Diagnostic("SD010", span, "a directive", "delete the line")
    if re.search("a tag:|tag handle", said):
        return Diagnostic("SD010", span, "a tag", "delete it; quote text that begins with !")
    known = ((message, hint) for pattern, message, hint in SYNTAX if re.search(pattern, said))
    message, hint = next(known, (f"the YAML cannot be read: {error.problem}", "check the indentation and the quotes"))
    opening = error.context_mark.line + 1 if error.context_mark else line + 1
    return Diagnostic("SD004", span, message.replace("#", str(opening)).replace("@", page.at(line, column)), hint)


def _blamed(page: Page, error: yaml.MarkedYAMLError, said: str) -> tuple[int, int]:
    """The place of a syntax error: where it shows, unless that is the end of the text and the opening tells more."""
    shows = (error.problem_mark.line, error.problem_mark.column) if error.problem_mark else (0, 0)
    opening = (error.context_mark.line, error.context_mark.column) if error.context_mark else shows
    place = opening if BLAMES_OPENING.search(said) or page.ends_before(*shows) else shows
    if page.ends_before(*place):
        return page.last_visible()
    if "quoted scalar" in said:  # libyaml marks the backslash, the pure parser what follows
        return place[0], max(place[1] if place == opening else 0, page.lines[place[0]].rfind("\\", 0, place[1] + 1))
    return place
