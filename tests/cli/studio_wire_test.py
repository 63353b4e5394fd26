#!/usr/bin/env python3
"""What `tessera studio` says and refuses over its socket: who may come in, and texts that pages edit."""
import hashlib
import http.client
import pathlib
import re
import stat
import unittest

from studio_case import SCENE, StudioTest
from studio_client import Closed, Page
from tessera_process import PATIENCE, marked_processes, wait_until


def hash_of(text):
    """Of a text that a page has, as it tells the program."""
    return hashlib.sha256(text.encode()).hexdigest()


class Access(StudioTest):
    def setUp(self):
        super().setUp()
        self.scene()
        self.running = self.studio("--workers", 1)

    def get(self, path, method="GET", **headers):
        connection = http.client.HTTPConnection(self.running.address, timeout=PATIENCE)
        connection.request(method, path, headers=headers)
        answer = connection.getresponse()
        answer.body = answer.read()
        connection.close()
        return answer

    def test_a_page_without_the_token_is_closed(self):
        for hello in ({"token": "0" * 32}, {"token": self.running.token[:-1]}, {}, {"token": ""}):
            page = Page(self.running.address)
            page.say("hello", **hello)
            self.assert_closed(page, 4401)
        for kind in ("list", "open", "unheard_of"):
            page = Page(self.running.address)
            page.say(kind, file="scene.tessera")
            self.assert_closed(page, 4401)
        for text in (b"", b"{", b"[]", b'{"hello": 1}', b'{"hello": {}, "list": {}}'):
            page = Page(self.running.address)
            page.send_frame(1, text)
            self.assert_closed(page, 4401)
        silent = Page(self.running.address)
        self.assert_closed(silent, 4401)
        self.assert_alive(self.running)

    def test_the_token_is_new_at_each_start_and_in_no_argument(self):
        other = self.studio("--workers", 1)
        self.assertNotEqual(self.running.token, other.token)
        self.assertRegex(self.running.token, r"\A[0-9a-f]{32,}\Z")
        for process in marked_processes(self.mark):
            try:
                seen = pathlib.Path(f"/proc/{process}/cmdline").read_bytes()
            except OSError:
                continue  # it has ended
            self.assertNotIn(self.running.token.encode(), seen)
        page = Page(other.address)
        page.say("hello", token=self.running.token)
        self.assert_closed(page, 4401)

    def test_host_and_origin_must_be_its_own(self):
        address = self.running.address
        port = address.rpartition(":")[2]
        cases = [(101, {}), (101, {"host": f"localhost:{port}", "origin": f"http://localhost:{port}"}),
                 (421, {"host": "evil.example"}), (421, {"host": f"evil.example:{port}"}),
                 (403, {"origin": "http://evil.example"}), (403, {"origin": "null"}),
                 (403, {"origin": f"http://127.0.0.1:{int(port) ^ 1}"}),
                 (403, {"origin": ""})]
        for status, asked in cases:
            page = Page(address, **asked)
            self.assertEqual(status, page.status, asked)
            page.close()
        self.assertEqual(421, self.get("/", Host="evil.example").status)

    def test_only_its_subprotocol_at_its_path(self):
        for asked in ({"protocol": ""}, {"protocol": "tessera-studio.2"}, {"path": "/"}, {"path": "/else"}):
            page = Page(self.running.address, **asked)
            self.assertIn(page.status, range(400, 500), asked)
            page.close()
        self.assertIn(self.get("/studio").status, range(400, 500))

    def test_the_page_and_its_headers(self):
        nonces = set()
        for _ in range(2):
            answer = self.get("/")
            self.assertEqual(200, answer.status)
            policy = answer.getheader("Content-Security-Policy")
            for part in ("default-src 'none'", "script-src 'self'", "frame-ancestors 'none'"):
                self.assertIn(part, policy)
            self.assertNotIn("unsafe", policy)
            nonce = re.search(r"style-src[^;]*'nonce-([^']+)'", policy)[1]
            self.assertIn(nonce.encode(), answer.body)
            nonces.add(nonce)
            for name, value in (("X-Content-Type-Options", "nosniff"), ("Referrer-Policy", "no-referrer"),
                                ("Cross-Origin-Opener-Policy", "same-origin"),
                                ("Cross-Origin-Resource-Policy", "same-origin")):
                self.assertEqual(value, answer.getheader(name), name)
            self.assertIsNone(answer.getheader("Access-Control-Allow-Origin"))
            self.assertIsNone(answer.getheader("Set-Cookie"))
        self.assertEqual(2, len(nonces), "one for each answer")
        page = self.get("/").body.decode()
        self.assertNotIn(self.running.token, page)
        named = re.findall(r'(?:src|href)="([^"]+)"', page)
        self.assertTrue(named)
        for name in named:
            self.assertNotIn("//", name)
            answer = self.get("/" + name.lstrip("./"))
            self.assertEqual(200, answer.status, name)
            self.assertTrue(answer.body)
        for path in ("/scene.tessera", "/../scene.tessera", "/%2e%2e/x", "/nothing"):
            self.assertIn(self.get(path).status, (400, 404), path)
        for method in ("POST", "PUT", "DELETE"):
            self.assertEqual(405, self.get("/", method).status, method)

    def test_the_page_is_told_version_and_build(self):
        told = self.page(self.studio("--workers", 1)).welcome["program"]
        self.assertEqual(f"tessera {told}", self.run_program("--version").out.strip())

    def test_what_is_unknown_is_ignored(self):
        page = self.page(self.running)
        page.say("of_a_newer_page", anything=[1, {"a": None}])
        page.say("list", also="unknown")
        names = [each["name"] for each in page.receive("files")["entries"]]
        self.assertEqual(["scene.tessera"], names)
        self.assertEqual([], [kind for kind, _ in page.waiting if kind == "refused"])

    def test_messages_that_make_no_sense_are_refused_alone(self):
        page = self.page(self.running)
        self.open(page)
        deep = '{"edit": {"file": ' + "[" * 40 + "]" * 40 + "}}"
        texts = ["{", "[]", "3", '{"list": 1}', '{"list": {}, "open": {}}', deep,
                 '{"edit": {"file": 3, "base": 1, "changes": []}}',
                 '{"edit": {"file": "scene.tessera", "base": 1, "changes": [[0]]}}',
                 '{"edit": {"file": "scene.tessera", "base": 1, "changes": [[-1, 0, "x"]]}}',
                 '{"edit": {"file": "scene.tessera", "base": 1, "changes": [[0, 1e9, "x"]]}}',
                 '{"edit": {"file": "scene.tessera", "base": 1, "changes": [[5, 6, "x"], [0, 1, "y"]]}}',
                 '{"view": {"pane": 99, "file": "scene.tessera", "size": [1, 1]}}',
                 '{"view": {"pane": 0, "file": "scene.tessera", "size": [0, 1]}}',
                 '{"view": {"pane": 0, "file": "scene.tessera", "size": [9, 9], "camera": {"fov": 180}}}',
                 '{"view": {"pane": 0, "file": "scene.tessera", "size": [9, 9], "overrides": {"spp": "x"}}}',
                 '{"view": {"pane": 0, "file": "scene.tessera", "size": [9, 9], "overrides": {"none": 1}}}']
        for text in texts:
            page.send_frame(1, text.encode())
            with self.subTest(text):
                self.assertTrue(page.receive("refused")["why"])
        self.assertEqual(2, self.edit(page, 1, (0, 0, "# still\n")))

    def test_viewers_see_and_submitters_edit(self):
        tokens = self.write("tokens", "a" * 32 + " viewer Ann\n" + "b" * 32 + " submitter Bob\n")
        tokens.chmod(0o600)
        studio = self.studio("--workers", 1, "--http-token", tokens)
        self.assertIsNone(studio.token)
        ann, bob = (self.page(studio, token=letter * 32) for letter in "ab")
        self.assertEqual([True, False], [each.welcome["read_only"] for each in (ann, bob)])
        self.open(bob)
        self.assertTrue(self.open(ann)["read_only"])
        for kind, fields in (("edit", {"base": 1, "changes": [[0, 0, "x"]]}), ("save", {}), ("take_over", {})):
            ann.say(kind, file="scene.tessera", **fields)
            self.assertIn("viewer", ann.receive("refused")["why"])
        self.show(ann, overrides={"spp": 1})
        self.last_picture(ann)
        self.assertEqual(2, self.edit(bob, 1, (0, 0, "# Bob\n")))
        self.assertEqual([[0, 0, "# Bob\n"]], ann.receive("change")["changes"])
        wrong = Page(studio.address)
        wrong.say("hello", token="c" * 32)
        self.assert_closed(wrong, 4401)

    def test_other_machines_need_a_token_file(self):
        result = self.run_program("studio", self.opened, "--http", "0.0.0.0:0", "--no-open")
        self.assert_error(result, 2, "--http-token")

    def test_a_flood_ends_that_page_alone(self):
        page, other = self.page(self.running), self.page(self.running)
        with self.assertRaises((Closed, OSError)) as ended:
            for _ in range(3000):
                page.say("list")
            while True:
                page.receive("nothing")
        if isinstance(ended.exception, Closed) and ended.exception.code is not None:
            self.assertEqual(1008, ended.exception.code)
        self.open(other)
        self.assertEqual(2, self.edit(other, 1, (0, 0, "# other\n")))

    def test_a_message_that_is_too_large_ends_that_page_alone(self):
        page, other = self.page(self.running), self.page(self.running)
        with self.assertRaises((Closed, OSError)):
            page.send_frame(1, b'{"list": {"x": "' + b"x" * (17 << 20) + b'"}}')
            while True:
                page.receive("nothing")
        other.say("list")
        other.receive("files")

    def test_who_says_no_hello_keeps_nobody_out(self):
        silent = [Page(self.running.address) for _ in range(40)]
        for page in silent:
            self.addCleanup(page.close)
        self.assertEqual({101}, {page.status for page in silent})
        self.open(self.page(self.running))

    def test_only_so_many_pages(self):
        pages = [self.page(self.running) for _ in range(32)]
        self.assertEqual(503, Page(self.running.address).status)
        pages.pop().close()
        def is_let_in():
            page = Page(self.running.address)
            page.close()
            return page.status == 101
        wait_until(is_let_in, "there is a place again")


class Texts(StudioTest):
    def setUp(self):
        super().setUp()
        self.path = self.scene()

    def both(self):
        studio = self.studio("--workers", 1)
        return self.page(studio), self.page(studio)

    def test_edits_are_counted_and_a_late_one_is_answered_by_the_text(self):
        page, _ = self.both()
        self.assertEqual((1, SCENE), tuple(map(self.open(page).get, ("version", "text"))))
        self.assertEqual(2, self.edit(page, 1, (0, 0, "# ä😀\n")))
        # Offsets are counted in UTF-16: the smile is two.
        self.assertEqual(3, self.edit(page, 2, (2, 3, "ö"), (5, 5, "!")))
        page.say("edit", file="scene.tessera", base=1, changes=[[0, 0, "late"]])
        answer = page.receive("document")
        self.assertEqual((3, "# ö😀!\n" + SCENE), (answer["version"], answer["text"]))
        self.assertEqual(SCENE, self.path.read_text(), "nothing is saved by itself")

    def test_a_file_that_is_not_open_cannot_be_edited(self):
        page, _ = self.both()
        page.say("edit", file="scene.tessera", base=1, changes=[])
        self.assertIn("not open", page.receive("refused")["why"])

    def test_two_pages_of_a_file(self):
        first, second = self.both()
        self.assertFalse(self.open(first)["read_only"])
        self.assertTrue(self.open(second)["read_only"])
        second.say("edit", file="scene.tessera", base=1, changes=[[0, 0, "x"]])
        self.assertIn("take it over", second.receive("refused")["why"])
        self.edit(first, 1, (0, 0, "# one\n"))
        change = second.receive("change")
        self.assertEqual((1, [[0, 0, "# one\n"]]), (change["base"], change["changes"]))
        second.say("take_over", file="scene.tessera")
        self.assertFalse(second.receive("document")["read_only"])
        lost = first.receive("document")
        self.assertEqual((2, True, "# one\n" + SCENE), (lost["version"], lost["read_only"], lost["text"]))
        self.assertEqual(3, self.edit(second, 2, (0, 5, "# two")))
        first.say("edit", file="scene.tessera", base=3, changes=[[0, 0, "x"]])
        self.assertIn("take it over", first.receive("refused")["why"])

    def test_a_page_that_was_cut_off_goes_on(self):
        studio = self.studio("--workers", 1)
        page = self.page(studio)
        self.open(page)
        self.edit(page, 1, (0, 0, "# a\n"))
        page.close()
        again = self.page(studio, resume=page.welcome["id"], have={"scene.tessera": [2, hash_of("# a\n" + SCENE)]})
        self.assertEqual(page.welcome["id"], again.welcome["id"], "it is the same page")
        self.assertEqual(2, again.receive("edited")["version"])
        self.assertEqual(3, self.edit(again, 2, (0, 0, "# b\n")))
        # Of what was sent and not acknowledged, the page learns from the text.
        again.close()
        third = self.page(studio, resume=again.welcome["id"], have={"scene.tessera": [2, hash_of("# a\n" + SCENE)]})
        text = third.receive("document")
        self.assertEqual((3, "# b\n# a\n" + SCENE, False), tuple(map(text.get, ("version", "text", "read_only"))))

    def test_a_page_resumes_before_its_old_connection_is_known_to_be_lost(self):
        studio = self.studio("--workers", 1)
        page = self.page(studio)
        self.open(page)
        self.edit(page, 1, (0, 0, "# a\n"))
        again = self.page(studio, resume=page.welcome["id"], have={"scene.tessera": [2, hash_of("# a\n" + SCENE)]})
        self.assertEqual(2, again.receive("edited")["version"])
        self.assertEqual(3, self.edit(again, 2, (0, 0, "# b\n")))
        self.assert_closed(page, 1000)

    def wait_for_draft(self):
        """The files of drafts, once they are whole."""
        drafts = self.folder / "state/tessera/studio"

        def files():
            found = [each for each in drafts.glob("*") if each.is_file()]
            is_kept = any(b"unsaved" in each.read_bytes() for each in found if each.suffix != ".part")
            return is_kept and found
        return wait_until(files, "the draft is kept")

    def test_after_a_crash_the_text_is_offered(self):
        studio = self.studio("--workers", 1)
        page = self.page(studio)
        self.open(page)
        self.edit(page, 1, (0, 0, "# unsaved ä\n"))
        for path in self.wait_for_draft():
            self.assertEqual(0o600, stat.S_IMODE(path.stat().st_mode), path)
        self.kill(studio)
        self.assertEqual(SCENE, self.path.read_text())
        page = self.page(self.studio("--workers", 1))
        offered = self.open(page)
        self.assertEqual((SCENE, "# unsaved ä\n" + SCENE), (offered["text"], offered["draft"]["text"]))
        page.say("recover", file="scene.tessera", take=True)
        self.edit(page, offered["version"], (0, 0, "# unsaved ä\n"))
        page.say("save", file="scene.tessera")
        page.receive("saved")
        self.assertEqual("# unsaved ä\n" + SCENE, self.path.read_text())
        self.kill(self.studios[0])
        page = self.page(self.studio("--workers", 1))
        self.assertNotIn("draft", self.open(page))

    def offered_a_draft(self):
        """The page of a studio that was started again after one was killed with unsaved text."""
        page = self.page(self.studio("--workers", 1))
        self.open(page)
        self.edit(page, 1, (0, 0, "# unsaved\n"))
        self.wait_for_draft()
        self.kill(self.studios[0])
        page = self.page(self.studio("--workers", 1))
        self.assertIn("draft", self.open(page))
        return page

    def test_a_draft_that_is_refused_is_gone(self):
        page = self.offered_a_draft()
        page.say("recover", file="scene.tessera", take=False)
        page.say("list")
        page.receive("files")  # after what was asked of the files before
        self.kill(self.studios[0])
        page = self.page(self.studio("--workers", 1))
        self.assertNotIn("draft", self.open(page))

    def test_a_draft_that_is_put_off_outlives_a_save(self):
        page = self.offered_a_draft()
        self.edit(page, 1, (0, 0, "# later\n"))
        page.say("save", file="scene.tessera")
        page.receive("saved")
        self.kill(self.studios[0])
        page = self.page(self.studio("--workers", 1))
        offered = self.open(page)
        self.assertEqual(("# later\n" + SCENE, "# unsaved\n" + SCENE), (offered["text"], offered["draft"]["text"]))


if __name__ == "__main__":
    unittest.main()
