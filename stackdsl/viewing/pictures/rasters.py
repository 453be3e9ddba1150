"""SVG -> PNG, and several of them -> GIF or WebP that moves; by libraries that come with an extra."""

from collections.abc import Sequence
from io import BytesIO

HINT = "pip install 'stackdsl[picture]'"


def png(svg: str, zoom: float = 2.0) -> bytes:
    """A picture with so many pixels for each of SVG, along one side. Raises ModuleNotFoundError without resvg."""
    import resvg_py  # noqa: PLC0415 -- an extra

    return bytes(resvg_py.svg_to_bytes(svg_string=svg, zoom=zoom))


def moving(svgs: Sequence[str], rate: float, form: str) -> bytes:
    """Pictures one after the other, so many a second, as `gif` or `webp`, again and again."""
    from PIL import Image  # noqa: PLC0415 -- likewise

    frames = [Image.open(BytesIO(png(svg, zoom=1.0))).convert("RGB") for svg in svgs]
    found = BytesIO()
    settings = {"quality": 80, "method": 4} if form == "webp" else {"optimize": True}
    frames[0].save(
        found, form, save_all=True, append_images=frames[1:], duration=round(1000.0 / rate), loop=0, **settings
    )
    return found.getvalue()
