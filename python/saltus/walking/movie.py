#!/usr/bin/env python3
"""Makes a video of a whole-body run from its view.

Usage: python3 -m saltus.walking.movie RESULTS, a folder with view.html; writes movie.mp4 into it, or movie.gif
without ffmpeg. Needs Chromium, which draws the view without a window.
"""

import base64
import io
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile

from . import events
from ..on_folder import on_folder
from ..whole_file import whole_file

RATE = 20  # pictures per second
SIZE = (640, 526)  # size of the window in pixels; the bar of the view takes 46
PATIENCE = 20  # s per picture; without a graphics card it takes about one
BEFORE, AFTER = 0.5, 2.0  # s shown before the first push, and after the last landing or push
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")


def span(folder):
    """The interval of the run that is shown, s."""
    with open(os.path.join(folder, "summary.json"), encoding="utf-8") as file:
        summary = json.load(file)
    return events.span(summary, BEFORE, AFTER)


def pictures_of(page, begin, end, rate=RATE):
    """JPEG files at a given rate."""
    browser = next((path for path in map(shutil.which, BROWSERS) if path), None)
    if browser is None:
        sys.exit("no movie: there is no Chromium; install the package chromium")
    with tempfile.TemporaryDirectory(prefix="saltus-movie-") as profile:
        command = [browser, "--headless", "--no-sandbox", "--disable-gpu", "--use-gl=angle",
                   "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--hide-scrollbars",
                   f"--user-data-dir={profile}", f"--window-size={SIZE[0]},{SIZE[1]}",
                   "--dump-dom",
                   f"file://{page}#movie={rate}&from={begin:.3f}&to={end:.3f}"]
        patience = 60 + PATIENCE * (end - begin) * rate
        try:
            dump = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                                  timeout=patience, check=False).stdout.decode()
        except subprocess.TimeoutExpired:
            sys.exit(f"no movie: Chromium did not draw the view within {patience:.0f} s")
    found = re.search(r'<pre id="film">([^<]*)</pre>', dump)
    if found is None or not found.group(1).strip():
        sys.exit("no movie: Chromium did not draw the view (it needs WebGL)")
    return [base64.b64decode(line) for line in found.group(1).split()]


def write_mp4(pictures, path):
    command = ["ffmpeg", "-y", "-loglevel", "error", "-f", "image2pipe", "-framerate", str(RATE),
               "-c:v", "mjpeg", "-i", "-", "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-c:v", "libx264",
               "-pix_fmt", "yuv420p", "-f", "mp4", path]
    done = subprocess.run(command, input=b"".join(pictures), stderr=subprocess.PIPE, check=False)
    if done.returncode != 0:
        sys.exit("no movie: ffmpeg failed: " + done.stderr.decode(errors="replace").strip())


def write_gif(pictures, path):
    try:
        from PIL import Image
    except ModuleNotFoundError:
        sys.exit("no movie: install the package ffmpeg, or python3-pil for a GIF")
    step = 2  # every second picture, half the size
    frames = [Image.open(io.BytesIO(p)).resize((SIZE[0] // 2, SIZE[1] // 2)) for p in pictures[::step]]
    frames[0].save(path, format="GIF", save_all=True, append_images=frames[1:],
                   duration=1000 * step // RATE, loop=0)


def main(folder):
    page = os.path.abspath(os.path.join(folder, "view.html"))
    if not os.path.exists(page):
        raise FileNotFoundError(2, "no such file", page)
    begin, end = span(folder)
    print(f"Drawing {round((end - begin) * RATE)} frames, up to one second each ...", flush=True)
    pictures = pictures_of(page, begin, end)
    has_ffmpeg = shutil.which("ffmpeg") is not None
    name = "movie.mp4" if has_ffmpeg else "movie.gif"
    with whole_file(os.path.join(folder, name)) as partial:
        (write_mp4 if has_ffmpeg else write_gif)(pictures, partial)
    print(f"{len(pictures)} pictures, {len(pictures) / RATE:.1f} s: {os.path.join(folder, name)}")


if __name__ == "__main__":
    on_folder(main, __doc__, "a run with --plant dart or mujoco writes a view")
