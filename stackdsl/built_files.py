"""Writes the files that a build generates from the models of the language: JSON Schema and stubs of the Python API.

A build adds them to the wheel, or to the checkout of an editable install; `python -m stackdsl.built_files` writes them
into the checkout again. No module of the package reads them.
"""

from pathlib import Path

from stackdsl.api.words import CLAIM_WORDS, IMPACT_WORDS, LAYOUT_WORDS
from stackdsl.language.json_schema import schema_text


def write_built_files(package: Path) -> None:
    """Write the generated files into the folder of the package. Raises OSError."""
    made = {"scenario.schema.json": schema_text()}
    for words in (CLAIM_WORDS, IMPACT_WORDS, LAYOUT_WORDS):
        made[f"api/{words.name}.pyi"] = words.stub()
    for name, text in made.items():
        file, content = package / name, text.encode()
        if not file.exists() or file.read_bytes() != content:  # mypy may read it at the same time
            file.write_bytes(content)


if __name__ == "__main__":
    write_built_files(Path(__file__).parent)
