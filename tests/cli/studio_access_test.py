#!/usr/bin/env python3
"""The page of `tessera studio` for whoever has no mouse, or needs other colours: every command by keys, keys that are
changed, themes, and what axe finds."""
import pathlib
import unittest

from png import read_png
from studio_browser import StudioPageTest
from studio_case import SCENE
from tessera_process import PROGRAM, wait_until

AXE = pathlib.Path(PROGRAM).parents[1] / "studio/page/work/node_modules/axe-core/axe.min.js"
PANELS = ("Files", "Models", "Script", "View", "Scene", "Properties", "Problems", "Console", "Graphs", "Farm", "Animation")
DIALOGS = {"Save as…": "Save as", "Settings": "Settings", "Keys…": "Keys", "About": "About",
           "Render: full picture with options…": "Full picture", "Export picture or scene…": "Export"}


class AccessTest(StudioPageTest):
    def run_command(self, page, name):
        """By its whole name."""
        page.press("F1")
        wait_until(lambda: page.has("dialog", "Commands"), "the commands are listed")
        page.type(name)
        names = 'dialog [role="option"] .name'
        wait_until(lambda: page.evaluate(f"[...document.querySelectorAll('{names}')].some((each) => "
                                         f"each.textContent === {name!r})"), f"{name} is found")
        at = page.evaluate(f"[...document.querySelectorAll('{names}')].findIndex((each) => each.textContent === {name!r})")
        page.press("Down", at)
        page.press("Enter")


class Commands(AccessTest):
    def test_every_command_by_keys_alone(self):
        page = self.begin()
        page.press("F1")
        wait_until(lambda: page.has("dialog", "Commands"), "the commands are listed")
        names = page.evaluate("[...document.querySelectorAll('dialog [role=\"option\"] .name')].map((each) => each.textContent)")
        page.press("Escape")
        self.assertGreater(len(names), 50)
        # A headless browser has no full screen.
        for name in [each for each in names if each != "Full screen"]:
            with self.subTest(name):
                self.run_command(page, name)
                if title := DIALOGS.get(name):
                    wait_until(lambda: page.has(f'dialog[aria-label^="{title}"]'), f"{name}: its dialog is open")
                elif name == "Commands":
                    wait_until(lambda: page.has("dialog", "Commands"), "the commands are listed")
                elif name.startswith("Show "):
                    panel = name.removeprefix("Show ")
                    wait_until(lambda: page.evaluate("document.activeElement.closest('section')?.getAttribute("
                                                     "'aria-label')") == panel, f"the focus is in {panel}")
                page.press("Escape")
                wait_until(lambda: not page.has("dialog"), f"{name}: no dialog is left")
                if page.state["file"] is None:
                    self.run_command(page, "Open: list of files")
                    page.press("Enter")
                self.until(page, lambda state: state["file"] is not None, f"{name}: a file is open")
        self.assertEqual("open", page.state["connection"])

    def test_toolbar_buttons_do_what_they_say(self):
        page = self.begin()
        for label, title in (("Export", "Export"), ("Commands", "Commands"), ("Settings", "Settings")):
            page.click_on(".toolbar button", label)
            wait_until(lambda: page.has(f'dialog[aria-label^="{title}"]'), f"{label} opens its dialog")
            page.press("Escape")
            wait_until(lambda: not page.has("dialog"), "it is closed")


class Keys(AccessTest):
    def open_keys(self, page, part):
        page.press("F1")
        page.type("keys")
        page.press("Enter")
        wait_until(lambda: page.has("dialog", "Reset all"), "the keys are listed")
        page.type(part)
        wait_until(lambda: page.evaluate("document.querySelectorAll('.key-row').length") == 1, "one command is left")

    def change(self, page, key):
        page.press("Tab")  # from the field, or from the button that was pressed
        page.press("Enter")
        page.press(key)

    def test_a_key_is_changed_and_outlasts_the_page(self):
        page = self.begin()
        self.open_keys(page, "go to line")
        page.press("Ctrl-A")
        page.type("find prev")
        self.change(page, "Ctrl-Shift-L")
        wait_until(lambda: page.has(".key-row kbd", "Ctrl-Shift-L"), "it has the key")
        page.press("Escape")
        wait_until(lambda: not page.has("dialog"), "the dialog is closed")
        kept = self.folder / "config/tessera/studio.json"
        wait_until(lambda: kept.exists() and "Ctrl-Shift-L" in kept.read_text(), "the program keeps it")
        self.navigate(page)
        self.until(page, lambda state: state["connection"] == "open", "it is connected")
        page.press("F1")
        page.type("find prev")
        wait_until(lambda: page.has('dialog [role="option"]', "Ctrl-Shift-L"), "F1 lists it")

    def test_a_changed_key_runs_its_command_and_the_old_one_does_not(self):
        page = self.begin()
        self.open_keys(page, "theme: light")
        self.change(page, "Ctrl-S")
        wait_until(lambda: page.has(".key-row .why", "which the command “Save” has"), "it is refused")
        for key, why in (("Ctrl-T", "the browser keeps"), ("x", "types or moves"), ("Ctrl-C", "text fields have")):
            page.press(key)
            wait_until(lambda: page.has(".key-row .why", why), why)
        page.press("Escape")
        self.assertTrue(page.has("dialog"), "Escape leaves the key alone")
        self.assertFalse(page.has(".key-row kbd"))
        page.press("Enter")
        page.press("Alt-L")
        wait_until(lambda: page.has(".key-row kbd", "Alt-L"), "it has the key")
        page.press("Escape")
        page.press("Alt-L")
        self.until(page, lambda state: state["theme"] == "light", "the key runs it")
        page.click_on(".cm-scroller")
        self.open_keys(page, "undo")
        self.change(page, "Alt-U")
        wait_until(lambda: page.has(".key-row kbd", "Alt-U"), "it has the key")
        page.press("Escape")
        self.write_at(page, 1, "#")
        typed = page.script
        page.press("Ctrl-Z")
        self.assertEqual(typed, page.script)
        page.press("Alt-U")
        self.assertEqual(SCENE, page.script)


    def test_a_key_of_the_view_is_replaced_and_removed(self):
        page = self.begin()
        self.open_keys(page, "frame the selection")
        wait_until(lambda: page.has(".key-row kbd", "F in the view"), "its key is listed")
        self.change(page, "w")
        wait_until(lambda: page.has(".key-row .why", "which the command “Camera: move forward” has"), "it is refused")
        page.press("i")
        wait_until(lambda: page.has(".key-row kbd", "I in the view"), "it has the key")
        page.press("Escape")
        wait_until(lambda: not page.has("dialog"), "the dialog is closed")
        self.open_keys(page, "exposure: half a stop more")
        page.click_on(".key-row button", "None")
        wait_until(lambda: not page.has(".key-row kbd"), "it has no key")
        page.press("Escape")
        wait_until(lambda: not page.has("dialog"), "the dialog is closed")
        page.click_on(".view-frame")
        page.press("f")
        page.press("]")
        page.press("[")
        self.until(page, lambda state: state["view"]["exposure"] == -0.5, "one of two keys is left")
        self.assertEqual("scene", page.state["camera"]["mode"], "the key that it had does nothing")
        page.press("i")
        self.until(page, lambda state: state["camera"]["mode"] == "free", "the new key runs it")


class Small(AccessTest):
    """A narrow window, and one at a zoom of 400 %."""
    BUTTONS = "[...document.querySelectorAll('.view-bar button, .view-bar select')]"

    def test_all_of_the_view_is_reached(self):
        page = self.begin()
        for width, height in ((320, 640), (320, 180)):
            page.resize(width, height)
            self.run_command(page, "Show View")
            wait_until(lambda: page.has(".view-bar button", "Refresh"), "the view is shown")
            for index in range(page.evaluate(f"{self.BUTTONS}.length")):
                page.evaluate(f"{self.BUTTONS}[{index}].focus()")
                page.evaluate(f"{self.BUTTONS}[{index}].scrollIntoView({{ block: 'nearest' }})")
                left, top, right, bottom = page.evaluate(f"""(() => {{
                    const box = {self.BUTTONS}[{index}].getBoundingClientRect();
                    return [box.left, box.top, box.right, box.bottom];
                  }})()""")
                self.assertTrue(0 <= left < right <= width and 0 <= top < bottom <= height,
                                (width, height, index, left, top, right, bottom))
            self.assertGreaterEqual(page.evaluate("document.querySelector('.picture').clientHeight"), 120)
            # What can be scrolled back by a person may stay scrolled.
            stuck = page.evaluate("""[...document.querySelectorAll("*")].filter((each) =>
                (each.scrollLeft !== 0 && !/auto|scroll/.test(getComputedStyle(each).overflowX) ||
                 each.scrollTop !== 0 && !/auto|scroll/.test(getComputedStyle(each).overflowY))
                && each !== document.scrollingElement).map((each) => each.className)""")
            self.assertEqual([], stuck)
            page.evaluate("scrollTo(0, 1e6)")
            _, _, _, top, _, low = page.box(".status-bar")
            self.assertLessEqual(top + low, height + 1, "the page scrolls to its end")
            self.assertEqual(0, page.evaluate("scrollX"))


class Themes(AccessTest):
    def test_the_theme_outlasts_the_page(self):
        page = self.begin()
        for theme in ("light", "dark"):
            page.press("F1")
            page.type(f"theme: {theme}")
            page.press("Enter")
            self.until(page, lambda state: state["theme"] == theme, theme)
            kept = self.folder / "config/tessera/studio.json"
            wait_until(lambda: kept.exists() and f'"{theme}"' in kept.read_text(), "the program keeps it")
            self.navigate(page)
            self.until(page, lambda state: state["theme"] == theme, f"{theme} again")

    def test_the_theme_is_the_systems_where_that_is_chosen(self):
        page = self.begin()
        self.run_command(page, "Theme: as the system")
        for theme in ("dark", "light", "dark"):
            page.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": theme}])
            self.until(page, lambda state: state["theme"] == theme, f"the system is {theme}")
        self.run_command(page, "Theme: light")
        self.until(page, lambda state: state["theme"] == "light", "a theme that is chosen is that, whatever the system has")

    def test_the_ground_of_the_picture_is_chequered_by_theme(self):
        page = self.begin(file=None)
        grounds = {}
        for theme in ("dark", "light"):
            self.run_command(page, f"Theme: {theme}")
            self.until(page, lambda state: state["theme"] == theme, theme)
            page.wait_for_frames()
            page.screenshot(self.folder / "ground.png")
            width, _, pixels = read_png(self.folder / "ground.png")
            bytes_a_pixel = len(pixels) // (width * 720)
            _, _, x, y, _, _ = map(round, page.box(".picture"))
            # Squares of 20 pixels: the middles of the first four in a row.
            grounds[theme] = [pixels[((y + 10) * width + x + 10 + 20 * square) * bytes_a_pixel:][:3] for square in range(4)]
            first, second = grounds[theme][:2]
            self.assertNotEqual(first, second)
            self.assertEqual([first, second] * 2, grounds[theme])
        self.assertNotEqual(grounds["dark"], grounds["light"])

    def test_contrast_is_chosen_or_the_systems(self):
        page = self.begin()
        normal = self.colours(page)
        self.run_command(page, "Contrast: high")
        self.until(page, lambda state: state["contrast"] == "high", "the contrast is high")
        self.assertNotEqual(normal, self.colours(page))
        self.run_command(page, "Contrast: as the system")
        self.until(page, lambda state: state["contrast"] == "normal", "the system wants none")
        page.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-contrast", "value": "more"}])
        self.until(page, lambda state: state["contrast"] == "high", "the system wants it")

    def colours(self, page):
        return page.evaluate("(() => { const s = getComputedStyle(document.body); return [s.color, s.backgroundColor]; })()")

    def test_forced_colours_tell_what_is_chosen(self):
        page = self.begin()
        page.call("Emulation.setEmulatedMedia", features=[{"name": "forced-colors", "value": "active"}])
        wait_until(lambda: page.evaluate("matchMedia('(forced-colors: active)').matches"), "colours are forced")
        page.click_on(".view-frame")
        page.press("Space")
        wait_until(lambda: page.has('[aria-pressed="true"]'), "the view is paused")
        for chosen, other in (('[role="tab"][aria-selected="true"]', '[role="tab"][aria-selected="false"]'),
                              ('button[aria-pressed="true"]', '.view-bar button[aria-pressed="false"], .toolbar button')):
            grounds = [page.evaluate(f"getComputedStyle(document.querySelector({each!r})).backgroundColor")
                       for each in (chosen, other)]
            self.assertNotEqual(*grounds, chosen)


class Motion(AccessTest):
    def moving(self, page):
        """What moves or is to move by itself while the editor has the focus."""
        page.click_on(".cm-scroller")
        page.wait_for_frames()
        return page.evaluate("""[document.getAnimations().length, [...document.querySelectorAll("*")].filter((each) =>
            [null, "::before", "::after"].some((part) => {
              const { animationName, transitionDuration, scrollBehavior } = getComputedStyle(each, part);
              return animationName !== "none" || /[1-9]/.test(transitionDuration) || scrollBehavior === "smooth";
            })).length]""")

    def test_nothing_moves_by_itself_where_that_is_wanted(self):
        page = self.begin()
        self.assertGreater(min(self.moving(page)), 0, "the cursor blinks")
        page.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-reduced-motion", "value": "reduce"}])
        self.navigate(page)
        self.until_final(page)
        self.assertEqual([0, 0], self.moving(page))


@unittest.skipUnless(AXE.exists(), "NO AXE-CORE: the page was not built beside the program")
class Accessibility(AccessTest):
    def findings(self, page, *rules):
        more = "".join(f", {rule!r}: {{enabled: true}}" for rule in rules)[2:]
        return page.evaluate(f"axe.run(document, {{resultTypes: ['violations'], rules: {{{more}}}}}).then((found) => "
                             "found.violations.map((each) => `${each.id}: ${each.nodes.map((node) => node.target).join(' ')}`))")

    def begin_with_axe(self):
        page = self.begin()
        page.evaluate(AXE.read_text() + "; 1")
        self.write_at(page, 5, " nodes { wrong")
        self.until(page, lambda state: state["problems"], "a problem is listed")
        return page

    def walk(self, page, look, *rules):
        """Every panel and dialog, as axe sees them."""
        for panel in PANELS:
            self.run_command(page, f"Show {panel}")
            wait_until(lambda: page.has(f'section[aria-label="{panel}"]'), f"{panel} is shown")
            self.assertEqual([], self.findings(page, *rules), f"{look}, {panel}")
        for command, title in {**DIALOGS, "Commands": "Commands", "Close file": "Unsaved changes"}.items():
            self.run_command(page, command)
            wait_until(lambda: page.has(f'dialog[aria-label^="{title}"]'), f"{title} is open")
            self.assertEqual([], self.findings(page, *rules), f"{look}, {title}")
            page.press("Escape")
            wait_until(lambda: not page.has("dialog"), f"{title} is closed")

    def test_no_findings_in_all_themes(self):
        page = self.begin_with_axe()
        for theme in ("light", "dark"):
            self.run_command(page, f"Theme: {theme}")
            self.until(page, lambda state: state["theme"] == theme, theme)
            self.walk(page, theme)

    def test_no_findings_with_high_contrast(self):
        page = self.begin_with_axe()
        self.run_command(page, "Contrast: high")
        for theme in ("light", "dark"):
            self.run_command(page, f"Theme: {theme}")
            self.until(page, lambda state: state["theme"] == theme, theme)
            self.walk(page, f"{theme}, high contrast", "color-contrast-enhanced")

    def test_no_findings_in_what_lies_over_picture_and_text(self):
        page = self.begin()
        page.evaluate(AXE.read_text() + "; 1")
        check = lambda what: self.assertEqual([], self.findings(page), what)
        page.click_on(".view-options summary")
        page.evaluate("""(() => { const select = document.querySelector(".view-options select");
            select.value = "depth"; select.dispatchEvent(new Event("change", { bubbles: true })); })()""")
        wait_until(lambda: page.has(".legend", "depth"), "the legend is open")
        check("legend")
        page.click_on(".view-options summary")
        page.click_on(".view-frame")
        page.press("p")
        page.press("Enter")
        wait_until(lambda: page.has(".probed td"), "the probe is open")
        check("probe")
        page.press("p")
        page.wait_for_frames()
        self.until_final(page)  # in the size that it has from now on
        page.press("c")
        wait_until(lambda: page.has(".compare"), "a picture is pinned")
        for key, seen in (("v", ".wipe-line"), ("n", ".compare .numbers td")):
            page.press(key)
            wait_until(lambda: page.has(seen), f"{seen} is seen")
            check(seen)
        page.click_on(".cm-scroller")
        page.press("Ctrl-End")
        page.type("\nnodes { ")
        page.press("Ctrl-Space")
        wait_until(lambda: page.has(".cm-tooltip-autocomplete li"), "words are proposed")
        check("completion list")

    def test_no_findings_in_a_narrow_window(self):
        page = self.begin_with_axe()
        page.resize(320, 640)
        self.walk(page, "320 points")

    def test_no_findings_with_forced_colours(self):
        page = self.begin_with_axe()
        page.call("Emulation.setEmulatedMedia", features=[{"name": "forced-colors", "value": "active"}])
        self.walk(page, "forced colours")


if __name__ == "__main__":
    unittest.main()
