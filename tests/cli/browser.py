"""Pages of a headless Chromium, driven over its DevTools pipe: no library, no port."""
import fcntl
import itertools
import json
import os
import select
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

from tessera_process import PATIENCE

PROGRAM = shutil.which("chromium") or shutil.which("chromium-browser")


class Browser:
    """A browser's process. It knows nothing of any test, so that all of a module share one."""

    def __init__(self):
        self.numbers = itertools.count(1)
        self.received = b""
        self.pages = {}
        self.folder = tempfile.TemporaryDirectory(prefix="tessera_browser_", ignore_cleanup_errors=True)
        self.reader, answers = os.pipe()
        commands, self.writer = os.pipe()
        # Clear of the two that they are to become.
        theirs_in, theirs_out = (fcntl.fcntl(end, fcntl.F_DUPFD_CLOEXEC, 10) for end in (commands, answers))
        os.close(commands)
        os.close(answers)
        # Chromium reads commands from descriptor 3 and answers on 4.
        command = 'exec 3<&"$1" 4>&"$2"; shift 2; exec "$@"'
        environment = {**os.environ, "HOME": self.folder.name, "TMPDIR": self.folder.name}
        self.process = subprocess.Popen(
            ["bash", "-c", command, "browser", str(theirs_in), str(theirs_out), PROGRAM, "--headless=new",
             "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run", "--mute-audio",
             "--disable-background-networking", "--disable-renderer-backgrounding",
             "--disable-backgrounding-occluded-windows", "--disable-background-timer-throttling",
             "--disable-component-update", "--disable-sync",
             "--remote-debugging-pipe", f"--user-data-dir={self.folder.name}/profile", "about:blank"],
            env=environment, pass_fds=(theirs_in, theirs_out), stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
        os.close(theirs_in)
        os.close(theirs_out)

    def call(self, method, session=None, **parameters):
        """The result of one DevTools command."""
        number = next(self.numbers)
        message = {"id": number, "method": method, "params": parameters}
        if session:
            message["sessionId"] = session
        os.write(self.writer, json.dumps(message).encode() + b"\0")
        while True:
            answer = self.next_message()
            if answer.get("id") == number:
                if "error" in answer:
                    raise AssertionError(f"{method}: {answer['error']}")
                return answer["result"]

    def next_message(self):
        """Waits for one; its page, if it is for one, has noted it."""
        deadline = time.monotonic() + PATIENCE
        while b"\0" not in self.received:
            ready, _, _ = select.select([self.reader], [], [], max(0, deadline - time.monotonic()))
            part = os.read(self.reader, 1 << 16) if ready else b""
            if not part:
                raise AssertionError("the browser has ended or hangs")
            self.received += part
        text, _, self.received = self.received.partition(b"\0")
        message = json.loads(text)
        if page := self.pages.get(message.get("sessionId")):
            page.note(message)
        return message

    def close(self):
        """Ends it and the processes of its group."""
        os.close(self.writer)
        os.close(self.reader)
        try:
            self.process.wait(timeout=10)
        except subprocess.TimeoutExpired:
            pass
        # Who is killed is there until the system has seen to it.
        try:
            for _ in range(500):
                os.killpg(self.process.pid, signal.SIGKILL)
                self.process.poll()
                time.sleep(0.01)
        except ProcessLookupError:
            pass
        self.process.wait()
        self.folder.cleanup()


running = []


def shared():
    """The browser of the module whose tests run, which ends with the last of them."""
    if not running:
        running.append(Browser())
        unittest.addModuleCleanup(lambda: running.pop().close())
    return running[0]


class Page:
    """A page that shares no cookie, store or cache with any other."""

    def __init__(self):
        self.browser = shared()
        self.complaints = []
        self.loaded = set()  # the loaders of the pages that are there whole
        self.context = self.browser.call("Target.createBrowserContext")["browserContextId"]
        target = self.browser.call("Target.createTarget", url="about:blank", browserContextId=self.context,
                                   newWindow=True)["targetId"]
        self.session = self.browser.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        self.browser.pages[self.session] = self
        for domain in ("Runtime", "Log", "Page"):
            self.call(f"{domain}.enable")
        self.call("Page.setLifecycleEventsEnabled", enabled=True)
        # Each believes that it has the focus, however many there are.
        self.call("Emulation.setFocusEmulationEnabled", enabled=True)

    def call(self, method, **parameters):
        """The result of one DevTools command to the page."""
        return self.browser.call(method, self.session, **parameters)

    def note(self, event):
        """Keeps which pages were loaded, and what the page's console would show in red, but for requests that fail."""
        if event.get("method") == "Page.lifecycleEvent" and event["params"]["name"] == "load":
            self.loaded.add(event["params"]["loaderId"])
        if event.get("method") == "Runtime.exceptionThrown":
            self.complaints.append(json.dumps(event["params"]["exceptionDetails"])[:500])
        if event.get("method") == "Log.entryAdded":
            entry = event["params"]["entry"]
            if entry["level"] == "error" and entry["source"] != "network":
                self.complaints.append(entry["text"])

    def load(self, address):
        """Loads the page at the address anew, even where it differs from the one before in its fragment alone."""
        self.call("Page.navigate", url="about:blank")
        loader = self.call("Page.navigate", url=address)["loaderId"]
        while loader not in self.loaded:
            self.browser.next_message()

    def reload(self):
        before = set(self.loaded)
        self.call("Page.reload")
        while self.loaded <= before:
            self.browser.next_message()

    def evaluate(self, expression):
        """The value of a JavaScript expression in the page."""
        result = self.call("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in result:
            raise AssertionError(f"{expression}: {result['exceptionDetails']}")
        return result["result"].get("value")

    def text(self, selector):
        return self.evaluate(f"document.querySelector({json.dumps(selector)})?.textContent ?? ''")

    def click(self, selector):
        self.evaluate(f"document.querySelector({json.dumps(selector)}).click()")

    def close(self):
        del self.browser.pages[self.session]
        self.browser.call("Target.disposeBrowserContext", browserContextId=self.context)
