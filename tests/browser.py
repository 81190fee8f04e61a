"""A real Chromium without a window, driven by its own protocol (DevTools) over two pipes."""

import base64
import json
import os
import select
import shutil
import subprocess
import time

FLAGS = [
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-dev-shm-usage",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--remote-debugging-pipe",
]  # fmt: skip
CODES = {
    "Backspace": 8,
    "Enter": 13,
    "ArrowLeft": 37,
    "ArrowUp": 38,
    "ArrowRight": 39,
    "ArrowDown": 40,
    "Escape": 27,
    "Home": 36,
    "End": 35,
    "PageUp": 33,
    "PageDown": 34,
}


def program():
    """Path of Chromium; None where there is none."""
    return next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)


class Browser:
    """One browser with one page; to be closed."""

    def __init__(self, folder):
        (commands, out), (self.answers, answers) = os.pipe(), os.pipe()
        started = ["bash", "-c", f'exec "$@" 3<&{commands} 4>&{answers}', "chromium", program(), *FLAGS]
        self.folder = folder
        with open(folder / "chromium.log", "w") as log:
            self.process = subprocess.Popen(
                [*started, f"--user-data-dir={folder}/profile"],
                stdout=log,
                stderr=log,
                pass_fds=(commands, answers),
            )
        for end in (commands, answers):
            os.close(end)
        self.out = os.fdopen(out, "wb", 0)
        self.session, self.asked, self.rest, self.heard = {}, 0, b"", []
        targets = self.ask("Target.getTargets")["targetInfos"]
        page = next(target["targetId"] for target in targets if target["type"] == "page")
        self.session = {
            "sessionId": self.ask("Target.attachToTarget", targetId=page, flatten=True)["sessionId"]
        }
        for domain in ("Page", "Runtime", "Log"):
            self.ask(f"{domain}.enable")

    def ask(self, method, **params):
        """What a command of the protocol returns."""
        self.asked += 1
        command = {"id": self.asked, "method": method, "params": params} | self.session
        self.out.write(json.dumps(command).encode() + b"\0")
        answer = self.hear(lambda message: message.get("id") == self.asked)
        if "error" in answer:
            raise RuntimeError(f"{method}: {answer['error']['message']}")
        return answer["result"]

    def hear(self, is_awaited, seconds=180):
        """The next message that is awaited; events before it are kept for `complaints`."""
        while True:
            while b"\0" not in self.rest:
                assert select.select([self.answers], [], [], seconds)[0], (
                    f"Chromium is silent for {seconds} s"
                )
                self.rest += (read := os.read(self.answers, 1 << 20))
                assert read, "Chromium has ended"
            message, _, self.rest = self.rest.partition(b"\0")
            if is_awaited(message := json.loads(message)):
                return message
            self.heard.append(message)

    def open(self, page, until="true"):
        """Load a page, of a path or of its text, and wait until an expression is true."""
        if isinstance(page, str):
            (self.folder / "page.html").write_text(page, encoding="utf-8")
            page = self.folder / "page.html"
        self.load(page.as_uri())
        self.wait_for(until)

    def view(self, page):
        """Load a page with a picture, and wait until it is drawn."""
        self.open(page, "document.body.dataset.ready")

    def load(self, address):
        """Load an address to its end."""
        self.ask("Page.navigate", url=address)
        self.hear(lambda message: message.get("method") == "Page.loadEventFired")

    def run(self, script, *values):
        """What a script returns, in the page; or that to which its promise leads."""
        call = f"(async function () {{\n{script}\n}}).apply(null, {json.dumps(values)})"
        options = {"awaitPromise": True, "returnByValue": True, "userGesture": True}
        answer = self.ask("Runtime.evaluate", expression=call, **options)
        if "exceptionDetails" in answer:
            raise RuntimeError(f"{answer['exceptionDetails']['exception']['description']} in {script}")
        return answer["result"].get("value")

    def wait_for(self, condition, seconds=30):
        """Wait until an expression of the page is true."""
        end = time.monotonic() + seconds
        while not self.run(f"return Boolean({condition})"):
            assert time.monotonic() < end, f"not within {seconds} s: {condition}; {self.complaints()}"
            time.sleep(0.05)

    def press(self, selector, *keys):
        """Type texts, and keys by their names, into an element."""
        self.run("document.querySelector(arguments[0]).focus()", selector)
        for key in (each for text in keys for each in ([text] if text in CODES else text)):
            typed = {"windowsVirtualKeyCode": CODES[key]} if key in CODES else {"text": key}
            self.ask("Input.dispatchKeyEvent", type="keyDown", key=key, **typed)
            self.ask("Input.dispatchKeyEvent", type="keyUp", key=key)

    def place(self, selector, x=0, y=0):
        """A place of the window: pixels from the middle of an element, which is scrolled into view."""
        box = (
            "const e = document.querySelector(arguments[0]); e.scrollIntoViewIfNeeded();"
            "const box = e.getBoundingClientRect(); return [box.left + box.width / 2, box.top + box.height / 2]"
        )
        left, top = self.run(box, selector)
        return {"x": left + x, "y": top + y}

    def point(self, selector, *moves, kind="mouse"):
        """Press at the first place (pixels from the middle of an element), move over the others, let go."""
        first, *others = (self.place(selector, *move) for move in moves)
        if kind == "touch":
            steps = [("touchStart", [first]), *(("touchMove", [each]) for each in others), ("touchEnd", [])]
            for name, fingers in steps:
                self.ask("Input.dispatchTouchEvent", type=name, touchPoints=fingers)
            return
        held = {"button": "left", "buttons": 1, "clickCount": 1}
        self.ask("Input.dispatchMouseEvent", type="mouseMoved", **first)
        self.ask("Input.dispatchMouseEvent", type="mousePressed", **first, **held)
        for each in others:
            self.ask("Input.dispatchMouseEvent", type="mouseMoved", **each, **held)
        self.ask("Input.dispatchMouseEvent", type="mouseReleased", **[first, *others][-1], **held)

    def click(self, selector):
        """Click on the middle of an element."""
        self.point(selector, (0, 0))

    def wheel(self, selector, down):
        """Turn the wheel over an element, by pixels."""
        place = self.place(selector)
        self.ask("Input.dispatchMouseEvent", type="mouseWheel", **place, deltaX=0, deltaY=down)

    def screen(self, width, height, telephone=True):
        """Show the page in that many pixels, as a telephone does or a window."""
        size = {"width": width, "height": height, "deviceScaleFactor": 1 + telephone, "mobile": telephone}
        self.ask("Emulation.setDeviceMetricsOverride", **size)

    def media(self, scheme="light", media=""):
        """Show the page in a colour scheme, on paper ("print") or on the screen."""
        features = [{"name": "prefers-color-scheme", "value": scheme}]
        self.ask("Emulation.setEmulatedMedia", media=media, features=features)

    def complaints(self):
        """Errors and warnings of the console since the last call, without what a software GPU says of its speed."""
        self.run("return 0")
        heard, self.heard = [(each.get("method"), each.get("params", {})) for each in self.heard], []
        said = [each["entry"] for name, each in heard if name == "Log.entryAdded"]
        said = [
            f"{entry['text']} {entry.get('url', '')}".strip()
            for entry in said
            if entry["level"] in ("error", "warning")
        ]
        said += [
            " ".join(str(value.get("value", value.get("description"))) for value in each["args"])
            for name, each in heard
            if name == "Runtime.consoleAPICalled" and each["type"] in ("error", "warning", "assert")
        ]
        thrown = [each["exceptionDetails"] for name, each in heard if name == "Runtime.exceptionThrown"]
        said += [each.get("exception", each).get("description", each["text"]) for each in thrown]
        return [text for text in said if "GL Driver Message (OpenGL, Performance" not in text]

    def screenshot(self):
        """The window as a picture, bytes of a PNG file."""
        return base64.b64decode(self.ask("Page.captureScreenshot")["data"])

    def close(self):
        """End the browser."""
        self.session = {}
        self.ask("Browser.close")
        self.process.wait(30)
        self.out.close()
        os.close(self.answers)
