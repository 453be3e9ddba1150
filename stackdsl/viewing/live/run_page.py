"""A live page of runs: what it is told, by whoever plays them. `live.ts` hears it."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from stability.model import BodyId
from stackdsl.viewing.live.showing import Showing


@dataclass
class RunPage:
    """What a page shows of some runs, which are known by their numbers."""

    showing: Showing
    runs: int = 0
    mistakes: tuple[str, ...] = ()  # in the file
    doing: str = ""  # while something is still to come

    def expect(self, runs: int) -> None:
        """There are so many runs from now on; those beyond are forgotten."""
        for number in range(runs, self.runs):
            self.showing.drop(f"run {number}")
            self.showing.drop(f"lines {number}")
        self.runs = runs

    def tell_mistakes(self, mistakes: Iterable[str]) -> None:
        """What is wrong with the file; what is seen of runs stays."""
        self.mistakes = tuple(mistakes)
        self._say()

    def tell_doing(self, doing: str) -> None:
        """What is being done; nothing any more, if this is empty."""
        self.doing = doing
        self._say()

    def _say(self) -> None:
        self.showing.put("status", {"runs": self.runs, "mistakes": self.mistakes, "doing": self.doing})

    def show(self, number: int, told: str) -> None:
        """A run as JSON, instead of what was shown of it."""
        self.showing.put_text(f"run {number}", f'{{"run":{number},"told":{told}}}')

    def note(self, number: int, lines: Sequence[str], weakest: BodyId | None = None) -> None:
        """What else there is to say of a run, and which of its bricks that calls the weakest."""
        self.showing.put(f"lines {number}", {"run": number, "lines": list(lines), "weakest": weakest})
