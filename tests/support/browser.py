"""The browser chromium without a window, by its debugging protocol: what a page draws, logs and asks for."""

import contextlib
import itertools
import json
import re
import subprocess
import time

OPTIONS = [
    *("--headless", "--no-sandbox", "--no-first-run", "--disable-quic", "--disable-sync", "--disable-component-update"),
    *("--disable-background-networking", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"),
    "--remote-debugging-port=0",
]
PATIENCE = 120.0
"""Seconds until a page that does not do what is waited for fails the test."""


class Page:
    """A page at a window width [px], in light or dark colours. events: what the browser told, in order."""

    def __init__(self, socket):
        self._socket, self._numbers, self.events = socket, itertools.count(1), []

    def call(self, method, **parameters):
        number = next(self._numbers)
        self._socket.send(json.dumps({"id": number, "method": method, "params": parameters}))
        while True:
            reply = json.loads(self._socket.recv(timeout=PATIENCE))
            if reply.get("id") == number:
                assert "error" not in reply, reply
                return reply["result"]
            self.events.append(reply)

    def value(self, expression):
        """What a JavaScript expression gives; a promise is waited for."""
        found = self.call("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in found, found
        return found["result"].get("value")

    def wait_for(self, expression):
        """Waits until a JavaScript expression is true."""
        end = time.monotonic() + PATIENCE
        while not self.value(f"!!({expression})"):
            assert time.monotonic() < end, f"never true: {expression}"
            time.sleep(0.1)

    def complaints(self):
        """Errors and exceptions of the page, and warnings that its scripts log."""
        found = [one["params"] for one in self.events if one["method"] == "Runtime.exceptionThrown"]
        logged = [one["params"] for one in self.events if one["method"] == "Runtime.consoleAPICalled"]
        entries = [one["params"]["entry"] for one in self.events if one["method"] == "Log.entryAdded"]
        found += [one for one in logged if one["type"] in ("error", "warning", "assert")]
        return found + [one for one in entries if one["level"] == "error"]

    def requests(self):
        """The addresses that the page asked for, but itself and what it carries."""
        asked = (one["params"] for one in self.events if one["method"] == "Network.requestWillBeSent")
        own = [one["request"]["url"] for one in asked if one["type"] != "Document"]
        return [one for one in own if not one.startswith(("data:", "blob:"))]


@contextlib.contextmanager
def browse(file, folder, width=1400, height=4000, dark=False):
    """The page of a file, drawn coarsely, as this is done without a GPU; `folder` takes the browser's profile."""
    from websockets.sync.client import connect

    command = ["chromium", *OPTIONS, f"--user-data-dir={folder}", "about:blank"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True) as browser:
        try:
            told = next(line for line in browser.stderr if "DevTools listening" in line)
            port = re.search(r"ws://127\.0\.0\.1:(\d+)/", told)[1]
            browser_address = f"ws://127.0.0.1:{port}{re.search(r'(/devtools/browser/.*)', told)[1]}"
            with connect(browser_address, open_timeout=PATIENCE) as control:
                control.send(json.dumps({"id": 1, "method": "Target.getTargets"}))
                targets = json.loads(control.recv())["result"]["targetInfos"]
                (target,) = (one["targetId"] for one in targets if one["type"] == "page")
                page_address = f"ws://127.0.0.1:{port}/devtools/page/{target}"
                with connect(page_address, open_timeout=PATIENCE, max_size=None) as socket:
                    page = Page(socket)
                    for domain in ("Page", "Runtime", "Network", "Log"):
                        page.call(f"{domain}.enable")
                    size = {"width": width, "height": height, "deviceScaleFactor": 0.25, "mobile": width < 500}
                    page.call("Emulation.setDeviceMetricsOverride", **size)
                    scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
                    page.call("Emulation.setEmulatedMedia", features=[scheme])
                    page.call("Page.navigate", url=f"file://{file}")
                    page.wait_for("document.readyState === 'complete'")
                    yield page
        finally:
            browser.kill()
            browser.stderr.close()
