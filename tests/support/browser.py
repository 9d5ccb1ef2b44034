"""A headless Chromium, spoken to by its DevTools protocol over pipes: no other package is needed."""

from __future__ import annotations

import base64
import json
import os
import shutil
import signal
import subprocess
import tempfile
from pathlib import Path
from typing import Any, Self

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")
FOUND = next(filter(None, map(shutil.which, NAMES)), None)
OPTIONS = (
    "--headless=new",
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--hide-scrollbars",
    "--no-first-run",
    "--disable-gpu-sandbox",
    "--remote-debugging-pipe",
)


class Browser:
    """One page of a browser. `errors`: what its console has complained of."""

    def __init__(self, width: int = 900, height: int = 700) -> None:
        self.errors: list[str] = []
        self._folder = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        out, self._to = os.pipe()
        self._from, back = os.pipe()

        def as_the_browser_has_them() -> None:  # it reads from 3 and writes to 4
            first, second = os.dup(out), os.dup(back)
            os.dup2(first, 3)
            os.dup2(second, 4)

        command = [str(FOUND), *OPTIONS, f"--user-data-dir={self._folder.name}", "about:blank"]
        self._process = subprocess.Popen(
            command,
            preexec_fn=as_the_browser_has_them,
            close_fds=False,
            env=dict(os.environ, TMPDIR=self._folder.name),  # where it leaves a socket behind
            start_new_session=True,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(out)
        os.close(back)
        self._read = os.fdopen(self._from, "rb")
        self._number, self._left, self._session = 0, b"", ""
        targets = self.call("Target.getTargets")["targetInfos"]
        page = next(target["targetId"] for target in targets if target["type"] == "page")
        self._session = self.call("Target.attachToTarget", targetId=page, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log"):
            self.call(f"{domain}.enable")
        self.resize(width, height)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        os.killpg(self._process.pid, signal.SIGKILL)  # its helpers too: a polite end leaves some, which still write
        self._process.wait(timeout=20)
        self._read.close()
        os.close(self._to)
        self._folder.cleanup()

    def call(self, method: str, **parameters: Any) -> Any:
        """Call a method of the protocol and return its result."""
        self._number += 1
        message: dict[str, Any] = {"id": self._number, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._to, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._next()
            if answer.get("id") == self._number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                return answer["result"]

    def _next(self) -> Any:
        while b"\0" not in self._left:
            part = os.read(self._from, 1 << 16)
            if not part:
                raise RuntimeError("the browser has ended")
            self._left += part
        text, _, self._left = self._left.partition(b"\0")
        found = json.loads(text)
        method, given = found.get("method"), found.get("params", {})
        if method == "Runtime.exceptionThrown":
            self.errors.append(str(given["exceptionDetails"]))
        elif (method == "Runtime.consoleAPICalled" and given["type"] in ("error", "warning")) or (
            method == "Log.entryAdded" and given["entry"]["level"] in ("error", "warning")
        ):
            self.errors.append(str(given))
        return found

    def open(self, path: Path) -> None:
        """Open a file and wait until it is loaded and drawn."""
        self.call("Page.navigate", url=path.resolve().as_uri())
        self.evaluate(
            "new Promise((done) => { const wait = () => requestAnimationFrame(() => requestAnimationFrame(done));"
            " document.readyState === 'complete' ? wait() : addEventListener('load', wait); })"
        )

    def evaluate(self, expression: str) -> Any:
        """Return the value of an expression in the page."""
        answer = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(f"{expression}: {answer['exceptionDetails']}")
        return answer["result"].get("value")

    def resize(self, width: int, height: int, ratio: float = 1.0, touch: bool = False) -> None:
        """Set the size of the page, px, and how many pixels of the screen one has."""
        self.call(
            "Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=ratio, mobile=touch
        )

    def prefer(self, scheme: str) -> None:
        """Ask for light or dark pages."""
        self.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])

    def click(self, x: float, y: float) -> None:
        """Press and release the mouse at a place, px."""
        for kind in ("mousePressed", "mouseReleased"):
            self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)

    def picture(self, path: Path) -> None:
        """Write what is seen as PNG."""
        path.write_bytes(base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"]))

    def print(self, path: Path) -> None:
        """Write the page as it is printed, as PDF."""
        path.write_bytes(base64.b64decode(self.call("Page.printToPDF", printBackground=False)["data"]))
