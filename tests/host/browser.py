"""A real browser for tests: Debian's chromium, spoken to over its debugging pipe.

Nothing to install beside ``chromium``; tests that need it skip with a word where it is absent.
Run as a program it takes the four pictures of pages::

    python tests/host/browser.py OUT_FOLDER PAGE.html...
"""

from __future__ import annotations

import base64
import json
import os
import select
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from types import TracebackType
from typing import Any

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("chrome")
FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--remote-debugging-pipe", "--hide-scrollbars",
)  # fmt: skip
FORMS = {  # form: width, height, mobile, colour scheme
    "desktop": (1280, 900, False, "light"),
    "phone": (390, 844, True, "light"),
    "dark": (1280, 900, False, "dark"),
}
PAPER = (703, 1000)
"""A4 less its margins, CSS pixels."""
LOOKS = (*FORMS, "print")


class Browser:
    """One chromium with one page; a context manager."""

    def __init__(self) -> None:
        assert CHROMIUM is not None
        self._home = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        there, self._out = os.pipe()
        self._in, back = os.pipe()
        # The browser reads from descriptor 3 and writes to 4; `there` and `back` are moved there.
        launch = (
            f'exec 8<&{there} 9>&{back}; exec 3<&8 4>&9 8<&- 9>&-; exec "$0" "$@" >/dev/null 2>&1'
        )
        words = [CHROMIUM, *FLAGS, f"--user-data-dir={self._home.name}", "about:blank"]
        self._process = subprocess.Popen(["bash", "-c", launch, *words], pass_fds=(there, back))
        os.close(there)
        os.close(back)
        self._buffer = b""
        self._number = 0
        self.complaints: list[str] = []
        self.requests: list[str] = []
        targets = self._call("Target.getTargets")["targetInfos"]
        page = next(t for t in targets if t["type"] == "page")
        answer = self._call("Target.attachToTarget", targetId=page["targetId"], flatten=True)
        self._session = str(answer["sessionId"])
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")

    def __enter__(self) -> Browser:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._process.terminate()
        self._process.wait(10)
        os.close(self._in)
        os.close(self._out)
        self._home.cleanup()

    def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        """One command of the DevTools protocol to the page; its result."""
        return self._call(method, self._session, **parameters)

    def _call(self, method: str, session: str | None = None, **parameters: Any) -> dict[str, Any]:
        self._number += 1
        number = self._number
        message: dict[str, Any] = {"id": number, "method": method, "params": parameters}
        if session:
            message["sessionId"] = session
        os.write(self._out, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._read(60.0)
            if answer.get("id") == number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                return dict(answer["result"])
            self._note(answer)

    def _read(self, limit_s: float) -> dict[str, Any]:
        end = time.monotonic() + limit_s
        while b"\0" not in self._buffer:
            ready, _, _ = select.select([self._in], [], [], max(0.0, end - time.monotonic()))
            part = os.read(self._in, 1 << 20) if ready else b""
            if not part:
                raise TimeoutError("the browser does not answer")
            self._buffer += part
        text, _, self._buffer = self._buffer.partition(b"\0")
        return dict(json.loads(text))

    def _note(self, event: dict[str, Any]) -> None:
        method, params = event.get("method"), event.get("params", {})
        if method == "Runtime.exceptionThrown":
            details = params["exceptionDetails"]
            said = details.get("exception", {}).get("description", "")
            self.complaints.append(f"{details.get('text')} {said}")
        elif method == "Runtime.consoleAPICalled" and params["type"] in (
            "error",
            "warning",
            "assert",
        ):
            self.complaints.append(
                str([a.get("value", a.get("description")) for a in params["args"]])
            )
        elif method == "Log.entryAdded" and params["entry"]["level"] in ("error", "warning"):
            self.complaints.append(params["entry"]["text"])
        elif method == "Network.requestWillBeSent":
            self.requests.append(params["request"]["url"])

    def evaluate(self, expression: str) -> Any:
        """Value of a JavaScript expression; promises are awaited."""
        answer = self.call(
            "Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True
        )
        if "exceptionDetails" in answer:
            raise RuntimeError(str(answer["exceptionDetails"]))
        return answer["result"].get("value")

    def open(self, page: Path, form: str = "desktop", limit_s: float = 60.0) -> None:
        """Load a page in a form and wait until all its plots are drawn."""
        paper = form == "print"
        width, height, mobile, scheme = (*PAPER, False, "light") if paper else FORMS[form]
        self.call(
            "Emulation.setDeviceMetricsOverride",
            width=width, height=height, deviceScaleFactor=1, mobile=mobile,
        )  # fmt: skip
        self.call(
            "Emulation.setEmulatedMedia",
            media="print" if paper else "screen",
            features=[{"name": "prefers-color-scheme", "value": scheme}],
        )
        self.call("Page.navigate", url="about:blank")
        self.requests.clear()
        self.call("Page.navigate", url=page.resolve().as_uri())
        end = time.monotonic() + limit_s
        ready = (
            "document.readyState === 'complete' && (!document.getElementById('library')"
            " || Boolean(document.documentElement.dataset.drawn))"
        )
        while not self.evaluate(ready):
            if self.complaints or time.monotonic() > end:
                raise RuntimeError(f"{page} in form {form}: not drawn: {self.complaints}")
            time.sleep(0.05)
        if paper:
            self.evaluate("window.dispatchEvent(new Event('beforeprint')), 1")

    def picture(self, path: Path) -> None:
        """The whole page into a PNG file."""
        path.write_bytes(self.taken())

    def taken(self) -> bytes:
        """The whole page as PNG."""
        size = self.call("Page.getLayoutMetrics")["cssContentSize"]
        answer = self.call(
            "Page.captureScreenshot", format="png", captureBeyondViewport=True,
            clip={"x": 0, "y": 0, "width": size["width"], "height": size["height"], "scale": 1},
        )  # fmt: skip
        return base64.b64decode(answer["data"])

    def printed(self, path: Path) -> None:
        """The page as PDF on A4."""
        answer = self.call(
            "Page.printToPDF", paperWidth=8.27, paperHeight=11.69, printBackground=True,
            preferCSSPageSize=True,
        )  # fmt: skip
        path.write_bytes(base64.b64decode(answer["data"]))


def main(words: list[str]) -> None:
    """Pictures of pages in all forms."""
    out = Path(words[0])
    out.mkdir(parents=True, exist_ok=True)
    with Browser() as browser:
        for word in words[1:]:
            page = Path(word)
            for form in LOOKS:
                browser.open(page, form)
                browser.picture(out / f"{page.stem}-{form}.png")
            browser.printed(out / f"{page.stem}-print.pdf")
        for complaint in browser.complaints:
            print(complaint)


if __name__ == "__main__":
    main(sys.argv[1:])
