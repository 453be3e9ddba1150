"""Pictures in a real browser: they can be read on light and dark pages."""

from typing import TYPE_CHECKING

import pytest

from tests.chromium import resize
from tests.paths import ROOT

if TYPE_CHECKING:
    from selenium.webdriver import Chrome

# The contrast of each text to the paper by WCAG 2.2, and its size where the picture is as wide as the window.
READ = """
const light = (colour) => {
  const parts = colour.match(/\\d+/g).slice(0, 3).map((part) => part / 255);
  const [r, g, b] = parts.map((part) => (part <= 0.04045 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4));
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
};
const svg = document.documentElement, paper = light(getComputedStyle(svg.querySelector('rect')).fill);
return [...svg.querySelectorAll('text')].map((text) => {
  const style = getComputedStyle(text), ink = light(style.fill);
  const contrast = (Math.max(ink, paper) + 0.05) / (Math.min(ink, paper) + 0.05);
  return [contrast, parseFloat(style.fontSize) * innerWidth / svg.viewBox.baseVal.width];
});
"""


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
@pytest.mark.parametrize(
    ("name", "width", "smallest"), [("leaning-column.svg", 380, 9.0), ("pictures/gallery/jenga-exact.svg", 420, 9.0)]
)
def test_texts_of_a_picture_can_be_read_on_a_phone(
    browser: "Chrome", name: str, width: int, smallest: float, dark: bool
) -> None:
    browser.get((ROOT / "docs" / name).as_uri())
    resize(browser, width, 600, dark=dark)
    texts = browser.execute_script(READ)
    assert len(texts) > 5
    assert min(contrast for contrast, _ in texts) >= 4.5
    assert min(size for _, size in texts) >= smallest
