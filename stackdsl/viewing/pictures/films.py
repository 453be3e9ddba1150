"""SVGs one after the other -> MP4, by the ffmpeg of this machine, where there is one."""

import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from stackdsl.viewing.pictures.rasters import png

PROGRAM: Final = "ffmpeg"
REMEDY: Final = "install ffmpeg (https://ffmpeg.org; on Debian: apt install ffmpeg), or write a .webp or .gif"
# Players want sides that are even, and colour at half of the pixels. Which encoder there is, the program knows best.
SETTINGS: Final = ("-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2:color=white", "-pix_fmt", "yuv420p", "-movflags", "+faststart")


class FilmError(RuntimeError):
    """There is no ffmpeg, or it could not make a film of this; the message says which."""


def film_maker() -> str:
    """The path of the ffmpeg of this machine. Raises FilmError if there is none."""
    found = shutil.which(PROGRAM)
    if found is None:
        raise FilmError(f".mp4 needs {PROGRAM}, which is not on the path; {REMEDY}")
    return found


def mp4(svgs: Sequence[str], rate: float) -> bytes:
    """A film of pictures of one size, so many a second. Raises FilmError, and ModuleNotFoundError without resvg."""
    program = film_maker()
    frames = b"".join(png(svg) for svg in svgs)
    with tempfile.TemporaryDirectory() as folder:  # a film has its index at its head, written when all is known
        film = Path(folder) / "film.mp4"
        told = ("-hide_banner", "-loglevel", "error", "-f", "image2pipe", "-c:v", "png", "-framerate", f"{rate:g}")
        command = [program, *told, "-i", "-", *SETTINGS, str(film)]
        try:
            done = subprocess.run(command, input=frames, capture_output=True, check=False)
        except OSError as error:
            raise FilmError(f"{program} cannot be started: {error.strerror}; {REMEDY}") from error
        if done.returncode or not film.is_file():
            said = done.stderr.decode("utf-8", "replace").strip().splitlines() or ["it says nothing"]
            raise FilmError(f"{program} made no film: {said[-1]}; {REMEDY}")
        return film.read_bytes()
