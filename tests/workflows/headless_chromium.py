"""Pages in Chromium without a window, over its devtools protocol.

Chromium reads commands from its file 3 and answers at its file 4, each message JSON with a zero at
its end (``--remote-debugging-pipe``): neither a driver nor a package is needed.
https://chromedevtools.github.io/devtools-protocol/
"""

from __future__ import annotations

import base64
import fcntl
import io
import json
import os
import select
import shutil
import subprocess
import time
from pathlib import Path

import pytest
from PIL import Image

NAMES = ("chromium", "chromium-browser", "google-chrome")
# The sandbox of Chromium refuses to work for root, and shared memory is small in containers.
OPTIONS = (
    *("--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"),
    *("--no-first-run", "--hide-scrollbars", "--remote-debugging-pipe"),
)
# A loaded machine may take long [s].
PATIENCE = 60.0


class Browser:
    """A browser with one page.

    Parameters
    ----------
    folder : Path
        For what the browser keeps.
    size : (int, int)
        Of the page [pixels].

    Attributes
    ----------
    errors : list of str
        What the console has told as an error since the browser was started.
    """

    def __init__(self, folder: Path, size: tuple[int, int] = (1500, 1000)) -> None:
        program = next(filter(None, map(shutil.which, NAMES)), None)
        if program is None:
            pytest.skip(f"no browser: none of {', '.join(NAMES)} is installed")
        window = f"--window-size={size[0]},{size[1]}"
        command = [program, *OPTIONS, f"--user-data-dir={folder}", window, "about:blank"]
        reads, self._commands = os.pipe()
        self._answers, writes = os.pipe()
        # Bash, since other shells know no file above 9; the files themselves may be 3 and 4.
        files = [fcntl.fcntl(file, fcntl.F_DUPFD, 10) for file in (reads, writes)]
        self._process = subprocess.Popen(
            ["bash", "-c", f'exec "$@" 3<&{files[0]} 4>&{files[1]}', "bash", *command],
            pass_fds=files,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        for file in (reads, writes, *files):
            os.close(file)
        self._unread, self._last, self._session = b"", 0, {}
        self.errors: list[str] = []
        pages = [
            one for one in self._call("Target.getTargets")["targetInfos"] if one["type"] == "page"
        ]
        page = {"targetId": pages[0]["targetId"], "flatten": True}
        self._session = {"sessionId": self._call("Target.attachToTarget", **page)["sessionId"]}
        for domain in ("Page", "Runtime", "Log"):
            self._call(f"{domain}.enable")

    def close(self) -> None:
        """End the browser."""
        self._process.kill()
        self._process.wait()
        os.close(self._commands)
        os.close(self._answers)

    def open(self, path: Path) -> None:
        """Open a file and wait until all of it is there."""
        self._call("Page.navigate", url=path.resolve().as_uri())
        self.wait("document.readyState === 'complete'")

    def value(self, expression: str):
        """The value of an expression of JavaScript, as plain data."""
        done = self._call("Runtime.evaluate", expression=expression, returnByValue=True)
        assert "exceptionDetails" not in done, f"{expression}: {done['exceptionDetails']}"
        return done["result"].get("value")

    def wait(self, expression: str) -> None:
        """Wait until an expression is true."""
        end = time.monotonic() + PATIENCE
        while not self.value(expression):
            assert time.monotonic() < end, f"does not come true: {expression}"
            time.sleep(0.05)

    def picture(self, selector: str) -> Image.Image:
        """What is seen of the first element that a CSS selector finds."""
        element = f"document.querySelector({json.dumps(selector)})"
        self.value(f"{element}.scrollIntoView()")
        x, y, width, height = self.value(
            "(seen => [seen.x + scrollX, seen.y + scrollY, seen.width, seen.height])"
            f"({element}.getBoundingClientRect())"
        )
        clip = {"x": x, "y": y, "width": width, "height": height, "scale": 1}
        shot = self._call("Page.captureScreenshot", clip=clip)
        return Image.open(io.BytesIO(base64.b64decode(shot["data"]))).convert("RGB")

    def shows_something(self, selector: str) -> bool:
        """Whether an element has more than one colour; a page inside another one may come late."""
        end = time.monotonic() + 0.1 * PATIENCE
        while all(low == high for low, high in self.picture(selector).getextrema()):
            if time.monotonic() > end:
                return False
            time.sleep(0.05)
        return True

    def moves(self, selector: str) -> bool:
        """Whether what is seen of an element changes by itself."""
        first, end = self.picture(selector), time.monotonic() + 0.2 * PATIENCE
        while self.picture(selector).tobytes() == first.tobytes():
            if time.monotonic() > end:
                return False
            time.sleep(0.05)
        return True

    def _call(self, method: str, **parameters):
        """Give a command and return its answer; take note of what is told in between."""
        self._last += 1
        command = {"id": self._last, "method": method, "params": parameters} | self._session
        message = memoryview(json.dumps(command).encode() + b"\0")
        while message:
            message = message[os.write(self._commands, message) :]
        while (answer := self._next()).get("id") != self._last:
            self._note(answer.get("method"), answer.get("params", {}))
        assert "error" not in answer, f"{method}: {answer['error']}"
        return answer["result"]

    def _next(self):
        """The next message."""
        while b"\0" not in self._unread:
            ready, _, _ = select.select([self._answers], [], [], PATIENCE)
            read = os.read(self._answers, 1 << 20) if ready else b""
            assert read, "the browser does not answer"
            self._unread += read
        message, _, self._unread = self._unread.partition(b"\0")
        return json.loads(message)

    def _note(self, method: str | None, told) -> None:
        if method == "Runtime.exceptionThrown":
            thrown = told["exceptionDetails"]
            self.errors.append(thrown.get("exception", {}).get("description", thrown["text"]))
        elif method == "Log.entryAdded" and told["entry"]["level"] == "error":
            self.errors.append(told["entry"]["text"])
        elif method == "Runtime.consoleAPICalled" and told["type"] in ("error", "assert"):
            parts = [one.get("value", one.get("description")) for one in told["args"]]
            self.errors.append(" ".join(map(str, parts)))
