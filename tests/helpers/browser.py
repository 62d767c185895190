"""Headless Chromium, driven over the pipe of its DevTools protocol."""

import json
import os
import shutil
import subprocess
import sys

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome", "chromium-headless-shell")
CHROMIUM = next((found for name in NAMES if (found := shutil.which(name))), None)
needs_chromium = pytest.mark.skipif(CHROMIUM is None, reason=f"there is none of {', '.join(NAMES)}")

LAUNCH = """
import fcntl, os, sys
ends = [fcntl.fcntl(int(end), fcntl.F_DUPFD, 10) for end in sys.argv[1:3]]
for place, end in enumerate(ends, 3):
    os.dup2(end, place)
os.execv(sys.argv[3], sys.argv[3:])
"""
"""Puts the ends of two pipes where Chromium looks for them, whatever their numbers are."""


class Browser:
    """One page; ``noted`` holds what went over the network, and errors and messages of the console."""

    def __init__(self, folder):
        there, self._write = os.pipe()
        self._read, back = os.pipe()
        options = ["--headless", "--no-sandbox", "--disable-gpu", "--remote-debugging-pipe", "--no-first-run"]
        options += [f"--user-data-dir={folder}", "--window-size=1200,900", "about:blank"]
        command = [sys.executable, "-c", LAUNCH, str(there), str(back), CHROMIUM, *options]
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        self._process = subprocess.Popen(command, pass_fds=(there, back), **quiet)
        os.close(there)
        os.close(back)
        self._buffer, self._number, self._session, self.noted, self._loaded = b"", 0, None, [], False
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Network", "Log"):
            self.call(f"{domain}.enable")
        self.resize(1200, 900)

    def resize(self, width, height):
        looks = {"deviceScaleFactor": 1, "mobile": width < 500}
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, **looks)

    def call(self, method, **parameters):
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._write, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._next()
            if answer.get("id") == self._number:
                assert "error" not in answer, answer
                return answer["result"]
            self._note(answer)

    def _next(self):
        while b"\0" not in self._buffer:
            part = os.read(self._read, 1 << 20)
            assert part, "the browser has ended"
            self._buffer += part
        first, _, self._buffer = self._buffer.partition(b"\0")
        return json.loads(first)

    def _note(self, event):
        name, content = event.get("method"), event.get("params", {})
        if name == "Network.requestWillBeSent" and not content["request"]["url"].startswith(
            ("file:", "data:", "blob:")
        ):
            self.noted.append(content["request"]["url"])
        self._loaded |= name == "Page.loadEventFired"
        if name in ("Runtime.exceptionThrown", "Runtime.consoleAPICalled", "Log.entryAdded"):
            self.noted.append(json.dumps(content))

    def open(self, address):
        """Load a page, another one first: an address that differs in its words alone would load nothing."""
        for each in ("about:blank", address):
            self.noted.clear()
            self._loaded = False
            self.call("Page.navigate", url=each)
            while not self._loaded:
                self._note(self._next())

    def evaluate(self, expression):
        """Return the value of an expression, of a promise what it becomes."""
        asked = {"expression": expression, "awaitPromise": True, "returnByValue": True}
        answer = self.call("Runtime.evaluate", **asked)
        assert "exceptionDetails" not in answer, answer
        return answer["result"].get("value")

    def close(self):
        self._process.kill()
        self._process.wait()
        os.close(self._read)
        os.close(self._write)
