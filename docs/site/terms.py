"""A Sphinx extension: each page links the first use of each term of the glossary, whose definition is its tooltip.

The pages stay as they are: GitHub shows them without these links.
"""

import re
from collections.abc import Iterator
from typing import Final

from docutils import nodes
from sphinx.addnodes import literal_strong
from sphinx.application import Sphinx

GLOSSARY: Final = "docs/glossary"
UNLINKED: Final = (GLOSSARY, "CHANGELOG")

# Words that mean something else in most sentences: they are terms only where they are emphasized.
EVERYDAY: Final = (
    "anchor, announced, design, error, extension, gone, group, guided, hit, limit, modification, observation, outcome, "
    "piece, reach, reading, refusal, room, set down, shape, share, snapshot, start, support, table, trace, unreliable, "
    "update, watch, world"
)
# Phrases in which a term is another word.
OTHERWISE: Final = ("by hand", "robot assembly", "frozen value", "frozen dataclass", "bearings or magnets")
# A text within one of these is no use of a term in a sentence.
APART: Final = (nodes.title, nodes.reference, nodes.literal, nodes.FixedTextElement, nodes.raw, literal_strong)


def rows(glossary: nodes.document) -> Iterator[tuple[str, str, nodes.row]]:
    """Yield each term of the glossary with its definition and its row."""
    for body in glossary.findall(nodes.tbody):
        for row in body.findall(nodes.row):
            term, meaning = (entry.astext() for entry in row.children[:2])
            yield term, meaning, row


def anchor(term: str) -> str:
    """Return the id of a term on the page of the glossary."""
    return f"term-{re.sub('[^a-z]+', '-', term.lower())}"


class Terms:
    """The terms of the glossary, and how a text is searched for them."""

    def __init__(self, glossary: nodes.document) -> None:
        self.meanings = {term: meaning for term, meaning, _ in rows(glossary)}
        self.everyday = self.meanings.keys() & set(EVERYDAY.split(", "))
        # A capital begins a sentence; `UNDECIDED` and `KAPLA plank` are always written in this way.
        self._spelled = {spelling: term for term in self.meanings for spelling in (term, term[0].upper() + term[1:])}
        longest_first = "|".join(map(re.escape, sorted([*self._spelled, *OTHERWISE], key=len, reverse=True)))
        self._pattern = re.compile(rf"(?<![\w-])({longest_first})s?(?![\w-])")

    def uses_in(self, text: str) -> Iterator[tuple[int, int, str]]:
        """Yield each use of a term: its begin, its end and the term."""
        for match in self._pattern.finditer(text):
            if match[1] not in OTHERWISE:
                yield *match.span(), self._spelled[match[1]]


def with_terms(app: Sphinx, page: nodes.document, docname: str) -> None:
    """Give each row of the glossary an anchor, and link the first use of each term on the other pages."""
    if docname == GLOSSARY:
        for term, _, row in rows(page):
            row["ids"].append(anchor(term))
    if docname in UNLINKED:
        return
    terms = Terms(app.env.get_doctree(GLOSSARY))
    target = app.builder.get_relative_uri(docname, GLOSSARY)
    linked: set[str] = set()
    for text in [*page.findall(nodes.Text)]:
        if not any(isinstance(above, APART) for above in above_of(text)):
            link_terms(text, terms, target, linked)


def above_of(node: nodes.Node) -> Iterator[nodes.Node]:
    """Yield the nodes around a node, from the inside to the outside."""
    while (node := node.parent) is not None:
        yield node


def link_terms(text: nodes.Text, terms: Terms, target: str, linked: set[str]) -> None:
    """Replace a text by parts in which the first uses of terms are links; `linked` has the terms of the page so far."""
    emphasized = isinstance(text.parent, (nodes.emphasis, nodes.strong))
    parts: list[nodes.Node] = []
    done = 0
    for begin, end, term in terms.uses_in(text):
        if term in linked or (term in terms.everyday and not (emphasized and (begin, end) == (0, len(text)))):
            continue
        linked.add(term)
        link = nodes.reference("", text[begin:end], refuri=f"{target}#{anchor(term)}", internal=True)
        link["classes"].append("term")
        link["reftitle"] = terms.meanings[term]
        parts += [nodes.Text(text[done:begin]), link]
        done = end
    if parts:
        text.parent.replace(text, [*parts, nodes.Text(text[done:])])


def setup(app: Sphinx) -> dict[str, bool]:
    """Attach the function above."""
    app.connect("doctree-resolved", with_terms)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
