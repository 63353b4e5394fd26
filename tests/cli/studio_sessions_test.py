#!/usr/bin/env python3
"""Sessions of odd use in a browser, drawn at random: typing, undoing, orbits, killed workers, reloads, stops, crashes
and saving. After each step the text is that of a model, and at the end file and picture are.

TESSERA_STUDIO_SESSIONS=500 asks for so many, some minutes for ten; TESSERA_STUDIO_SESSION=N repeats that one."""
import os
import random
import re
import signal

from studio_browser import StudioPageTest
from studio_case import SCENE
from tessera_process import is_worker, marked_processes, wait_until

STEPS = 12
WORDS = ("a word", "1 2 3", "äöü", "# again", "x = 7", "  ")
ONLY = os.environ.get("TESSERA_STUDIO_SESSION")
SESSIONS = [int(ONLY)] if ONLY else range(int(os.environ.get("TESSERA_STUDIO_SESSIONS", "6")))


class Session:
    """One user. `text` is what the editor has to hold."""

    def __init__(self, test, number):
        self.test, self.random, self.text = test, random.Random(number), SCENE
        self.page = test.begin("--workers", 2)

    def place(self, offset):
        """Goes there by keys."""
        before = self.text[:offset]
        self.page.click_on(".cm-scroller")
        self.page.press("Ctrl-Home")
        self.page.wait_for_frames()  # long lines are scrolled back with the next one, and Down goes by what is seen
        self.page.press("Down", before.count("\n"))
        self.page.press("Right", len(before) - (before.rfind("\n") + 1))

    def replace(self, start, end, new):
        self.place(start)
        self.page.press("Delete", end - start)
        self.page.type(new)
        self.page.press("Escape")  # whatever was proposed
        self.text = self.text[:start] + new + self.text[end:]

    # Steps.

    def write_a_comment(self):
        end = self.random.choice([found.start() for found in re.finditer("\n", self.text)])
        self.replace(end, end, " # " + self.random.choice(WORDS))

    def change_a_number(self):
        number = self.random.choice(list(re.finditer(r"(?<=radius: )[\d.]+|(?<=[rgb]: )[\d.]+", self.text)))
        self.replace(number.start(), number.end(), f"{self.random.uniform(.2, 1):.3f}")

    def break_and_mend(self):
        at = self.text.index("radius") + self.random.randrange(6)
        wrong = self.random.choice("xyz")
        self.replace(at, at, wrong)
        self.test.until(self.page, lambda state: state["problems"], "it is told to be wrong")
        self.replace(at, at + 1, "")
        self.test.until(self.page, lambda state: not state["problems"], "it is right again")

    def paste(self):
        lines = "".join(f"# line {self.random.randrange(100)}\n" for _ in range(self.random.randint(1, 30)))
        self.place(0)
        self.page.call("Input.insertText", text=lines)
        self.text = lines + self.text

    def undo_and_redo(self):
        self.write_a_comment()
        times = self.random.randint(1, 3)
        self.page.press("Ctrl-Z", times)
        wait_until(lambda: self.page.script != self.text, "it is undone")
        self.page.press("Ctrl-Shift-Z", times)

    def orbit(self):
        x, y = self.page.middle(".view-frame")
        self.page.drag((x, y), (x + self.random.randint(-80, 80), y + self.random.randint(-30, 30)))
        self.page.wheel(x, y, self.random.choice((-1, 1)))
        self.test.until(self.page, lambda state: state["camera"]["mode"] == "free", "the camera is moved")

    def kill_a_worker(self):
        workers = wait_until(lambda: [each for each in marked_processes(self.test.mark) if is_worker(each)],
                             "there are workers")
        os.kill(self.random.choice(workers), signal.SIGKILL)

    def reload(self):
        """Of what is saved: else the browser asks first."""
        self.save()
        self.page.reload()
        self.test.until(self.page, lambda state: state["connection"] == "open" and state["file"], "it is there again")

    def close_the_laptop(self):
        """The program stands still while a word is typed."""
        self.test.running.process.send_signal(signal.SIGSTOP)
        try:
            self.write_a_comment()
        finally:
            self.test.running.process.send_signal(signal.SIGCONT)

    def crash(self):
        """The program, while the page stays."""
        address = self.test.running.address
        self.test.kill(self.test.running)
        self.test.until(self.page, lambda state: state["connection"] == "lost", "the loss is said")
        self.test.running = self.test.studio("--workers", 2, http=address)
        self.test.until(self.page, lambda state: state["connection"] == "refused", "the token is another one")
        self.page.click_on('dialog input[aria-label="Token"]')
        self.page.type(self.test.running.token)
        self.page.press("Enter")
        self.test.until(self.page, lambda state: state["connection"] == "open", "it is connected again")

    def save(self):
        self.page.press("Ctrl-S")
        wait_until(lambda: self.test.saved() == self.text, "it is saved")
        self.test.until(self.page, lambda state: not state["dirty"], "the page knows")

    def check(self, did):
        wait_until(lambda: self.page.script == self.text or None, f"after {did} the text is what was typed")

    def run(self):
        steps = [self.write_a_comment, self.change_a_number, self.break_and_mend, self.paste, self.undo_and_redo,
                 self.orbit, self.kill_a_worker, self.reload, self.close_the_laptop, self.crash, self.save]
        done = []
        for _ in range(STEPS):
            step = self.random.choices(steps, [4, 6, 2, 1, 3, 4, 2, 1, 1, 1, 2])[0]
            done.append(step.__name__)
            step()
            self.check(done)
        self.page.click_on(".view-frame")
        self.page.press("Home")
        self.test.until(self.page, lambda state: state["camera"]["mode"] == "scene", "the scene's camera is back")
        self.save()
        view = self.test.until_final(self.page)["view"]
        self.test.assert_same(self.page.pixels()[2], self.test.rendered(size=(view["width"], view["height"])))


class Sessions(StudioPageTest):
    """Has a test for each session."""


for number in SESSIONS:
    setattr(Sessions, f"test_session_{number}", lambda self, number=number: Session(self, number).run())
