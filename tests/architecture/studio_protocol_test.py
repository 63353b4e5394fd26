#!/usr/bin/env python3
"""Messages and fields that the studio's page declares (studio/page/src/core/protocol.ts) are those that the
program reads and sends, in both directions."""
import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).parents[2]
STUDIO = ROOT / "studio"
PROTOCOL = re.sub(r"/\*\*.*?\*/|//[^\n]*", "", (STUDIO / "page/src/core/protocol.ts").read_text(), flags=re.DOTALL)
READER = (STUDIO / "page_message.cpp").read_text()
SOURCE_READER = (STUDIO / "source_request.cpp").read_text()
SENDERS = "\n".join(path.read_text() for folder in ("studio", "metrics", "scenes/formats", "coordinator/web")
                    for path in sorted((ROOT / folder).glob("*.cpp")))


def body(name):
    """Of an exported interface."""
    start = PROTOCOL.index(f"export interface {name} {{") + len(f"export interface {name} ")
    depth = 0
    for at in range(start, len(PROTOCOL)):
        depth += {"{": 1, "}": -1}.get(PROTOCOL[at], 0)
        if depth == 0:
            return PROTOCOL[start + 1:at]
    raise AssertionError(name)


def members(text):
    """The names of its own members, and what each is."""
    found, depth, line = {}, 0, ""
    for character in text:
        depth += {"{": 1, "[": 1, "(": 1, "}": -1, "]": -1, ")": -1}.get(character, 0)
        line += character
        if character == ";" and depth == 0:
            name = re.match(r"\s*\"?([\w-]+)\"?\??:", line)
            if name:
                found[name[1]] = line
            line = ""
    return found


def fields(text):
    """All names of fields in a type, those of the interfaces that it names included; places of lists have none."""
    text = re.sub(r"\[[^\[\]]*\]", "[]", text)
    names = set(re.findall(r"[{;,]\s*\"?([a-z][\w-]*)\"?\??:", text))
    for other in re.findall(r"\b[A-Z]\w+\b", text):
        if f"export interface {other} {{" in PROTOCOL:
            names |= set(members(body(other))) | fields("{" + body(other))
    return names


def source_kinds():
    """What asks something of a text, and whether that changes it."""
    return {name: changes == "true" for name, changes in re.findall(
        r"SourceKind\{Source::What::\w+,\s*\"(\w+)\",\s*(true|false)\}", SOURCE_READER)}


def kinds_read():
    text = READER
    table = text[text.index("parsers() {"):text.index("return all;")]
    found = set(re.findall(r"^\s*\{\"(\w+)\",", table, re.MULTILINE)) | set(re.findall(r"kind == \"(\w+)\"", text))
    return found | set(source_kinds())


def kinds_sent():
    """The kinds that stand where a message is made."""
    return set(re.findall(r"(?:page_answer|tell_all|tell_readers|message_of)\(\s*(?:[^,()\"]+(?:\([^()]*\))?[^,()\"]*,\s*)?"
                          r"\"(\w+)\"", SENDERS))


class Protocol(unittest.TestCase):
    def test_the_program_reads_what_the_page_says(self):
        self.assertEqual(sorted(kinds_read()), sorted(members(body("ToProgram"))))

    def test_both_sides_know_which_messages_change_a_text(self):
        text = (STUDIO / "page/src/entities.ts").read_text()
        listed = re.findall(r"\"(\w+)\"", re.search(r"TEXT_CHANGES = \[([^\]]*)\]", text)[1])
        self.assertEqual([name for name, changes in source_kinds().items() if changes], listed)

    def test_the_page_knows_what_the_program_says(self):
        known = set(members(body("ToPage")))
        self.assertGreater(len(kinds_sent()), 20)
        self.assertEqual(set(), kinds_sent() - known, "sent and not declared")
        self.assertEqual(set(), {each for each in known if f'"{each}"' not in SENDERS}, "declared and not sent")

    # What the page keeps for itself in the program, and options of `tessera render`, are passed on as they are.
    KEPT = {"settings", "workspace"}
    OPTIONS = {"Tone", "Overrides"}

    def test_the_program_reads_the_fields_that_the_page_says(self):
        said = set()
        for kind, text in members(body("ToProgram")).items():
            if kind not in self.KEPT:
                said |= fields(text.split(":", 1)[1])
        options = set().union(*(members(body(each)) for each in self.OPTIONS))
        text = READER
        read = set(re.findall(r"(?:get|get_whole|get_three|find)\(\"([\w-]+)\"", text))
        self.assertEqual(set(), said - read - options, "said and not read")
        self.assertEqual(set(), read - said, "read and not said")

    def test_the_program_sends_the_fields_that_the_page_knows(self):
        known = set()
        for kind, text in members(body("ToPage")).items():
            known |= fields(text.split(":", 1)[1])
        kept = set(members(body("Settings"))) | set(members(body("Workspace"))) | fields("{" + body("Workspace"))
        missing = {each for each in known - kept if f'"{each}"' not in SENDERS}
        self.assertEqual(set(), missing, "known and not sent")


if __name__ == "__main__":
    unittest.main()
