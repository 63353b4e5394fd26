"""The page of a studio in a real browser, worked with by keys and pointer as a person does."""
import base64
import json
import unittest

import browser
from studio_case import StudioTest
from tessera_process import wait_until

# What keys are called that make no sign: key, code, number.
NAMED = {"Enter": ("Enter", "Enter", 13), "Tab": ("Tab", "Tab", 9), "Escape": ("Escape", "Escape", 27),
         "Backspace": ("Backspace", "Backspace", 8), "Delete": ("Delete", "Delete", 46),
         "Home": ("Home", "Home", 36), "End": ("End", "End", 35), "Up": ("ArrowUp", "ArrowUp", 38),
         "Down": ("ArrowDown", "ArrowDown", 40), "Left": ("ArrowLeft", "ArrowLeft", 37),
         "Right": ("ArrowRight", "ArrowRight", 39), "PageUp": ("PageUp", "PageUp", 33),
         "PageDown": ("PageDown", "PageDown", 34), "Space": (" ", "Space", 32)}
NAMED |= {f"F{number}": (f"F{number}", f"F{number}", 111 + number) for number in range(1, 13)}
SIGNS = {".": ("Period", 190), ",": ("Comma", 188), "[": ("BracketLeft", 219), "]": ("BracketRight", 221),
         "+": ("Equal", 187), "-": ("Minus", 189)}
SHIFTED = {"[": "{", "]": "}"}
MODIFIERS = {"Alt": 1, "Ctrl": 2, "Shift": 8}
BUTTONS = {"left": 1, "right": 2, "middle": 4}
TEXT_OF = {"Enter": "\r", "Space": " "}


class StudioPage(browser.Page):
    dragged = None  # what the pointer has taken hold of, as the browser tells it
    traced = ()  # what the browser tells of its own work
    is_traced = False

    def note(self, event):
        super().note(event)
        if event.get("method") == "Input.dragIntercepted":
            self.dragged = event["params"]["data"]
        if event.get("method") == "Tracing.dataCollected":
            self.traced += event["params"]["value"]
        self.is_traced |= event.get("method") == "Tracing.tracingComplete"

    def press(self, keys, times=1):
        """Presses and lets go "Ctrl-Shift-S", say."""
        *held, name = [keys] if keys == "-" else keys.split("-")
        modifiers = sum(MODIFIERS[each] for each in held)
        text = TEXT_OF.get(name, "")
        if name in NAMED:
            key, code, number = NAMED[name]
        elif name in SIGNS:
            code, number = SIGNS[name]
            text = key = SHIFTED.get(name, name) if modifiers & 8 else name
        else:
            key = name.upper() if modifiers & 8 else name.lower()
            code, number = (f"Digit{name}" if name.isdigit() else f"Key{name.upper()}"), ord(name.upper())
            text = key
        if modifiers & 3:
            text = ""
        fields = {"modifiers": modifiers, "key": key, "code": code, "windowsVirtualKeyCode": number}
        for _ in range(times):
            self.call("Input.dispatchKeyEvent", type="keyDown" if text else "rawKeyDown", text=text, **fields)
            self.call("Input.dispatchKeyEvent", type="keyUp", **fields)

    def type(self, text):
        """Each sign of a text as a key of its own."""
        for sign in text:
            if sign == "\n":
                self.press("Enter")
                continue
            self.call("Input.dispatchKeyEvent", type="keyDown", text=sign, key=sign, unmodifiedText=sign,
                      windowsVirtualKeyCode=ord(sign.upper()) if sign.isalnum() and sign.isascii() else 0)
            self.call("Input.dispatchKeyEvent", type="keyUp", key=sign)

    def pointer(self, kind, x, y, button="none", buttons=0, held=(), **more):
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button=button, buttons=buttons,
                  modifiers=sum(MODIFIERS[each] for each in held), **more)

    def click_at(self, x, y, button="left", count=1):
        self.pointer("mouseMoved", x, y)
        self.pointer("mousePressed", x, y, button, BUTTONS[button], clickCount=count)
        self.pointer("mouseReleased", x, y, button, 0, clickCount=count)

    def drag(self, start, end, button="left", held=(), steps=6):
        self.pointer("mouseMoved", *start, held=held)
        self.pointer("mousePressed", *start, button, BUTTONS[button], held, clickCount=1)
        for step in range(1, steps + 1):
            at = [a + (b - a) * step / steps for a, b in zip(start, end)]
            self.pointer("mouseMoved", *at, button, BUTTONS[button], held)
        self.pointer("mouseReleased", *end, button, 0, held, clickCount=1)

    def drop_files(self, x, y, *paths):
        """Files from the desktop, dragged over the page and dropped there."""
        data = {"items": [], "files": [str(each) for each in paths], "dragOperationsMask": 1}
        for kind in ("dragEnter", "dragOver", "drop"):
            self.call("Input.dispatchDragEvent", type=kind, x=x, y=y, data=data)

    def drag_text(self, start, end):
        """Takes hold of what is selected there, and drops it elsewhere."""
        self.call("Input.setInterceptDrags", enabled=True)
        self.pointer("mouseMoved", *start)
        self.pointer("mousePressed", *start, "left", 1, clickCount=1)
        for step in (4, 8, 12):
            self.pointer("mouseMoved", start[0] + step, start[1], "left", 1)
        while self.dragged is None:
            self.browser.next_message()
        for kind in ("dragEnter", "dragOver", "drop"):
            self.call("Input.dispatchDragEvent", type=kind, x=end[0], y=end[1], data=self.dragged)
        self.pointer("mouseReleased", *end, "left", 0, clickCount=1)
        self.call("Input.setInterceptDrags", enabled=False)
        self.dragged = None

    def wheel(self, x, y, notches, held=()):
        self.pointer("mouseWheel", x, y, held=held, deltaX=0, deltaY=100 * notches)

    def box(self, selector, text=None, reach=False):
        """The middle, left, top, width and height of what is seen there, of the first that has the text. With `reach`
        it is scrolled to, and counts only where a pointer in its middle is over it, and not over a dialog, say."""
        return self.evaluate(f"""(() => {{
            for (const each of document.querySelectorAll({json.dumps(selector)})) {{
              if ({json.dumps(text)} !== null && !each.textContent.includes({json.dumps(text)})) continue;
              if ({json.dumps(reach)}) each.scrollIntoView({{block: "nearest"}});
              const box = each.getBoundingClientRect(), x = box.x + box.width / 2, y = box.y + box.height / 2;
              if (box.width > 0 && box.height > 0 && (!{json.dumps(reach)} || each.contains(document.elementFromPoint(x, y))))
                return [x, y, box.x, box.y, box.width, box.height];
            }}
            return null;
          }})()""")

    def middle(self, selector, text=None):
        """The middle of what is seen there, once a pointer reaches it and it has come to rest."""
        def at_rest():
            before = self.box(selector, text, True)
            self.wait_for_frames()
            return before if before == self.box(selector, text, True) else None
        return wait_until(at_rest, f"{selector} {text or ''} is seen, at rest, and nothing lies over it")[:2]

    def click_on(self, selector, text=None, **more):
        self.click_at(*self.middle(selector, text), **more)

    def has(self, selector, text=None):
        return self.box(selector, text) is not None

    def focused(self):
        """Name, role or text of what has the focus."""
        return self.evaluate("(() => { const e = document.activeElement; return e.getAttribute('aria-label') ?? "
                             "e.textContent.slice(0, 60); })()")

    @property
    def state(self):
        return self.evaluate("globalThis.tesseraStudio.state()")

    @property
    def script(self):
        return self.evaluate("globalThis.tesseraStudio.text()")

    def pixels(self, pane=0):
        """Width, height and the RGB bytes of the picture that is seen."""
        width, height, data = self.evaluate(f"globalThis.tesseraStudio.pixels({pane})" """.then((image) => {
            let text = "";
            for (let i = 0; i < image.data.length; i += 4)
              text += String.fromCharCode(image.data[i], image.data[i + 1], image.data[i + 2]);
            return [image.width, image.height, btoa(text)];
          })""")
        return width, height, base64.b64decode(data)

    def wait_for_frames(self):
        """Until what the pointer did was heard: moves come with the frames."""
        self.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")

    def layouts(self, expression):
        """The nodes from which parts of the page were laid out anew, until what the expression does was seen."""
        self.traced, self.is_traced = [], False
        self.call("Tracing.start", transferMode="ReportEvents",
                  traceConfig={"includedCategories": ["devtools.timeline"]})
        self.evaluate(expression)
        self.wait_for_frames()
        self.call("Tracing.end")
        while not self.is_traced:
            self.browser.next_message()
        return [root["nodeName"] for event in self.traced if event["name"] == "Layout"
                for root in event["args"].get("endData", {}).get("layoutRoots", [])]

    def screenshot(self, path):
        path.write_bytes(base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"]))

    def resize(self, width, height):
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)


@unittest.skipUnless(browser.PROGRAM, "NO CHROMIUM: the page of the studio is not tested; deploy/packages.txt has it")
class StudioPageTest(StudioTest):
    def tearDown(self):
        for page in getattr(self, "pages", []):
            page.close()
        # A program that is gone is tried again and again.
        complaints = [each for page in getattr(self, "pages", []) for each in page.complaints
                      if not each.startswith("WebSocket connection to")]
        super().tearDown()
        self.assertEqual([], complaints)

    def begin(self, *options, file="scene.tessera", scene=True):
        """The page of a studio, with that file open and its last picture shown."""
        if scene:
            self.scene()
        self.running = self.studio(*(options or ("--workers", 1)))
        return self.visit(file)

    def visit(self, file="scene.tessera"):
        self.pages = getattr(self, "pages", [])
        page = StudioPage()
        self.pages.append(page)
        page.resize(1280, 720)
        self.navigate(page)
        if file:
            page.click_on('.panel-files [role="option"]', file)
            self.until(page, lambda state: state["file"] == file, "the file is open")
            self.until_final(page)
        return page

    def navigate(self, page, token=None):
        page.load(f"{self.running.url}#token={token or self.running.token}")
        if token is None:
            self.until(page, lambda state: state["connection"] == "open", "it is connected")

    def until(self, page, condition, what):
        return wait_until(lambda: (state := page.state) and condition(state) and state, what)

    def until_final(self, page, after=None):
        """Waits for the last picture of what the text is now; its state."""
        return self.until(page, lambda state: state["picture"]["final"] and not state["picture"]["stale"]
                          and state["picture"]["version"] == state["version"]
                          and (after is None or state["picture"]["serial"] > after["picture"]["serial"]),
                          "the last picture is shown")

    def write_at(self, page, line, text, end=True):
        """Types at the end of a line, by the keys of the editor."""
        page.click_on(".cm-scroller")
        page.press("Ctrl-Home")
        page.press("Down", line - 1)
        page.press("End" if end else "Home")
        page.type(text)

    def saved(self, file="scene.tessera"):
        return (self.opened / file).read_text()
