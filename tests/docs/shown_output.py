"""Output as a page shows it, held against what is printed: `...` is any lines or words, `~` depends on the machine."""

from collections.abc import Sequence

ANY_LINES, ANY_WORD = "...", "~"


def differences(shown: str, printed: str) -> list[str]:
    """The lines that are shown and not printed, in this order; none if the page is right."""
    left = [line.split() for line in printed.splitlines() if line.strip()]
    missing, skipping = [], False
    for line in (line for line in shown.splitlines() if line.strip()):
        words = line.split()
        if words == [ANY_LINES]:
            skipping = True
            continue
        found = next((n for n, other in enumerate(left) if _same(words, other)), None)
        if found is None or (found and not skipping):
            missing.append(line)
        else:
            left = left[found + 1 :]
        skipping = False
    return missing if skipping or not left else [*missing, f"not shown: {' '.join(left[0])}"]


def _same(shown: Sequence[str], printed: Sequence[str]) -> bool:
    if shown[-1] == ANY_LINES:
        shown, printed = shown[:-1], printed[: len(shown) - 1]
    pairs = zip(shown, printed, strict=False)
    return len(shown) == len(printed) and all(_same_word(one, other) for one, other in pairs)


def _same_word(shown: str, printed: str) -> bool:
    return shown in (printed, ANY_WORD)
