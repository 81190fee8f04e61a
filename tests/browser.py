"""A real Chromium without a window, asked through Debian's chromedriver and plain HTTP (W3C WebDriver)."""

import base64
import json
import shutil
import socket
import subprocess
import time
import urllib.error
import urllib.request
from pathlib import Path

FLAGS = [
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
]  # fmt: skip
ELEMENT = "element-6066-11e4-a52e-4f735466cecf"  # the key of an element in the protocol


def programs():
    """Paths of chromium and chromedriver; None for one that is not there."""
    return shutil.which("chromium"), shutil.which("chromedriver")


class Browser:
    """One browser with one page; to be closed."""

    def __init__(self, folder, width=1000, height=700):
        browser, driver = programs()
        self.folder = Path(folder)
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.address = f"http://127.0.0.1:{free.getsockname()[1]}"
        port = self.address.rsplit(":", 1)[1]
        self.log = open(Path(folder, "driver.log"), "w")  # noqa: SIM115
        self.driver = subprocess.Popen([driver, f"--port={port}"], stdout=self.log, stderr=self.log)
        options = {"args": [*FLAGS, f"--user-data-dir={folder}/profile", f"--window-size={width},{height}"]}
        options["binary"] = browser
        asked = {"goog:chromeOptions": options, "goog:loggingPrefs": {"browser": "ALL"}}
        self.session = ""
        for _ in range(100):
            try:
                self.session = self.ask("POST", "", capabilities={"alwaysMatch": asked})["sessionId"]
                break
            except urllib.error.URLError:
                time.sleep(0.1)

    def ask(self, method, command, **content):
        """One request of the protocol; its value."""
        path = f"/session/{self.session}" if self.session else "/session"
        data = json.dumps(content).encode() if method == "POST" else None
        request = urllib.request.Request(self.address + path + command, data, method=method)
        try:
            with urllib.request.urlopen(request, timeout=180) as answer:
                return json.load(answer)["value"]
        except urllib.error.HTTPError as error:
            raise RuntimeError(json.load(error)["value"]["message"]) from None

    def open(self, address):
        """Load a page."""
        self.ask("POST", "/url", url=address)

    def run(self, script, *values):
        """What a script returns, in the page."""
        return self.ask("POST", "/execute/sync", script=script, args=list(values))

    def wait_for(self, condition, seconds=30):
        """Wait until an expression of the page is true."""
        end = time.monotonic() + seconds
        while not self.run(f"return Boolean({condition})"):
            assert time.monotonic() < end, f"not within {seconds} s: {condition}; {self.complaints()}"
            time.sleep(0.05)

    def find(self, selector):
        """Handle of an element."""
        return self.ask("POST", "/element", using="css selector", value=selector)[ELEMENT]

    def press(self, selector, keys):
        """Type into an element."""
        self.ask("POST", f"/element/{self.find(selector)}/value", text=keys)

    def click(self, selector):
        """Click on an element."""
        self.ask("POST", f"/element/{self.find(selector)}/click")

    def point(self, selector, *moves, kind="mouse", held=None):
        """Press at the first place (pixels from the middle of an element), move over the others, let go; with a key held."""
        origin = {ELEMENT: self.find(selector)}
        steps = [{"type": "pointerMove", "origin": origin, "x": x, "y": y, "duration": 20} for x, y in moves]
        steps.insert(1, {"type": "pointerDown", "button": 0})
        steps.append({"type": "pointerUp", "button": 0})
        pointer = {"type": "pointer", "id": kind, "parameters": {"pointerType": kind}, "actions": steps}
        key = {"type": "key", "id": "keys", "actions": [{"type": "keyDown", "value": held}]}
        key["actions"] += [{"type": "pause"}] * len(steps) + [{"type": "keyUp", "value": held}]
        steps.insert(0, {"type": "pause"})
        self.ask("POST", "/actions", actions=[pointer, key] if held else [pointer])

    def pinch(self, selector, *fingers):
        """Move fingers over an element at once, each from its first place to its second (pixels from the middle)."""
        origin, touches = {ELEMENT: self.find(selector)}, []
        for k, places in enumerate(fingers):
            begin, end = (
                {"type": "pointerMove", "origin": origin, "x": x, "y": y, "duration": 50} for x, y in places
            )
            steps = [begin, {"type": "pointerDown", "button": 0}, end, {"type": "pointerUp", "button": 0}]
            touch = {"type": "pointer", "id": f"finger {k}", "parameters": {"pointerType": "touch"}}
            touches.append(touch | {"actions": steps})
        self.ask("POST", "/actions", actions=touches)

    def wheel(self, selector, down):
        """Turn the wheel over an element, by pixels."""
        origin = {ELEMENT: self.find(selector)}
        scroll = {"type": "scroll", "origin": origin, "x": 0, "y": 0, "deltaX": 0, "deltaY": down}
        self.ask("POST", "/actions", actions=[{"type": "wheel", "id": "wheel", "actions": [scroll]}])

    def screen(self, width, height):
        """Show the page as a telephone of that many pixels does; None: as the window again."""
        what = {"width": width, "height": height, "deviceScaleFactor": 2, "mobile": True}
        name = "setDeviceMetricsOverride" if width else "clearDeviceMetricsOverride"
        self.ask("POST", "/goog/cdp/execute", cmd=f"Emulation.{name}", params=what if width else {})

    def complaints(self):
        """Errors and warnings of the console since the last call, without what a software GPU says of its speed."""
        entries = self.ask("POST", "/se/log", type="browser")
        loud = [entry["message"] for entry in entries if entry["level"] in ("SEVERE", "WARNING")]
        return [message for message in loud if "GL Driver Message (OpenGL, Performance" not in message]

    def screenshot(self):
        """The window as a picture, bytes of a PNG file."""
        return base64.b64decode(self.ask("GET", "/screenshot"))

    def close(self):
        """End the browser and its driver."""
        try:
            self.ask("DELETE", "")
        finally:
            self.driver.terminate()
            self.driver.wait()
            self.log.close()
