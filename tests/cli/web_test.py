#!/usr/bin/env python3
"""The coordinator's web page, API and viewers: the real program, and the page in a real browser."""
import json
import os
import re
import signal
import socket
import struct
import threading
import time
import unittest
import urllib.error
import urllib.request

import browser
import scenes
from png import read_png
from service_test import LOAD, TILES, ServiceTest
from studio_client import Studio
from tessera_process import PATIENCE, PROGRAM, SLOWER, TesseraTest, wait_until


class WebTest(ServiceTest):
    token = None

    def serve(self, *options, http="127.0.0.1:0"):
        """A coordinator that answers; `self.page` is its page."""
        process = super().serve("--http", http, *options)
        self.page = process.stdout.readline().split()[-1]
        self.assertTrue(self.page.startswith("http://"), self.page)
        return process

    def submit(self, *options):
        """The number of a job that the page knows."""
        job = super().submit(*options)
        # What is shown is up to a quarter of a second old.
        wait_until(lambda: self.get(f"/api/v1/jobs/{job}", token=self.token)[0] == 200, "the job is known")
        return job

    def get(self, path, token=None, data=None, **headers):
        """Status and body of one request."""
        if token:
            headers["Authorization"] = f"Bearer {token}"
        if data is not None:
            headers["Content-Type"] = "application/json"
        request = urllib.request.Request(self.page.rstrip("/") + path, headers=headers,
                                         data=None if data is None else json.dumps(data).encode())
        try:
            with urllib.request.urlopen(request, timeout=PATIENCE) as answer:
                return answer.status, answer.read()
        except urllib.error.HTTPError as error:
            return error.code, error.read()

    def api(self, path, **options):
        status, body = self.get("/api/v1/" + path, **options)
        self.assertEqual(200, status, body)
        return json.loads(body)


class Api(WebTest):
    def test_tells_of_a_job_to_its_end(self):
        service, worker = self.serve("--log-format", "json"), self.worker()
        self.assertEqual((200, b"ok\n"), self.get("/healthz"))
        wait_until(lambda: self.get("/readyz") == (200, b"ok\n"), "it is ready")
        job = self.submit("--name", "glass")
        wait_until(lambda: self.api(f"jobs/{job}")["state"] == "done", "the job is done")
        status, picture = self.get(f"/api/v1/jobs/{job}/preview.png")
        self.assertEqual((200, b"\x89PNG"), (status, picture[:4]))
        farm = self.api("farm")
        self.assertEqual(["glass"], [known["name"] for known in farm["jobs"]])
        self.assertEqual(TILES, farm["counters"]["tiles_done"])
        wait_until(lambda: self.api("farm")["workers"][0]["resident_bytes"] > 1e6, "the worker tells its memory")
        trace = self.api(f"jobs/{job}/trace.json")
        tiles = [event for event in trace["traceEvents"] if event.get("cat") == "tile"]
        self.assertEqual(TILES, len({event["name"] for event in tiles}))
        metrics = self.get("/metrics")[1]
        self.assertIn(b'tessera_tiles_total{state="done"} 300\n', metrics)
        commits = int(re.search(rb"tessera_store_commit_seconds_count (\d+)\n", metrics)[1])
        self.assertGreaterEqual(commits, TILES, "one a tile, and the job's")
        self.assertEqual(409, self.get(f"/api/v1/jobs/{job}/pause", data={})[0])
        texts = [line["text"] for line in self.api("log")["lines"]]
        self.assertTrue(any("has come" in text for text in texts), texts)
        service.send_signal(signal.SIGTERM)
        _, log = service.communicate(timeout=60)
        lines = [json.loads(line) for line in log.splitlines()]
        self.assertEqual(texts, [line["text"] for line in lines][:len(texts)])
        self.assertEqual({"serve"}, {line["process"] for line in lines})
        self.stop(worker)

    def test_whole_pictures_and_scenes(self):
        service, worker = self.serve(), self.worker()
        job = int(self.ask("submit", self.scene, "--size", "1200x20"))  # more than a preview has
        wait_until(lambda: self.api(f"jobs/{job}")["state"] == "done", "the job is done")
        picture = self.folder / "page.png"
        picture.write_bytes(self.get(f"/api/v1/jobs/{job}/picture.png")[1])
        self.assertEqual(0, self.run_program("fetch", job, "-o", "fetched.png", "--connect", self.endpoint).code)
        self.assertEqual((1200, 20), read_png(picture)[:2])
        self.assertTrue(read_png(picture) == read_png(self.folder / "fetched.png"), "the pictures differ")
        for path, code in ((f"jobs/{job}/picture.png?frame=1", 400), ("jobs/99/picture.png", 404),
                           (f"jobs/{job}/scene.tesserab?frame=1", 400), ("jobs/99/scene.tesserab", 404)):
            self.assertEqual(code, self.get("/api/v1/" + path)[0], path)
        self.stop(worker)
        self.spp += 1
        waiting = self.submit("--name", "none")
        self.assertEqual(404, self.get(f"/api/v1/jobs/{waiting}/picture.png")[0])
        for form in ("tessera", "tesserab"):
            self.assertEqual(200, self.get(f"/api/v1/jobs/{waiting}/scene.{form}")[0], form)
        self.stop(service)

    def test_orders(self):
        service = self.serve()
        job = self.submit()
        self.assertEqual("paused", self.api(f"jobs/{job}/pause", data={})["state"])
        self.assertIsNone(self.api(f"jobs/{job}")["exit_code"], "it has none yet")
        self.assertEqual(7, self.api(f"jobs/{job}/priority", data={"priority": 7})["priority"])
        result = self.run_program("status", job, "--json", "--connect", self.endpoint)
        status = json.loads(result.out)
        self.assertEqual(("paused", 7), (status["state"], status["priority"]))
        self.assertEqual(403, self.get(f"/api/v1/jobs/{job}/cancel", data={}, Origin="http://evil.example")[0])
        self.assertEqual("cancelled", self.api(f"jobs/{job}/cancel", data={})["state"])
        wait_until(lambda: self.api(f"jobs/{job}")["state"] == "cancelled", "it is shown")
        shown = self.api(f"jobs/{job}")
        self.assertEqual((4, 0, 1), (shown["exit_code"], shown["frames_done"], shown["frames_total"]))
        # Without keys and tokens there is nothing that it would read again.
        service.send_signal(signal.SIGHUP)
        wait_until(lambda: any("SIGHUP" in line["text"] for line in self.api("log")["lines"]), "it is told")
        self.stop(service)

    def test_tokens(self):
        tokens = self.write("tokens", "of-a-viewer-000001 viewer\nof-a-submitter-001 submitter\n")
        def refused(*options):
            return self.run_program("serve", "--bind", self.endpoint, *options)
        self.assert_error(refused("--http", "0.0.0.0:0"), 2, "other machines", "--http-token")
        self.assert_error(refused("--http", "127.0.0.1:0", "--http-token", tokens), 2, "mode 0600")
        self.assert_error(refused("--http", "nowhere"), 2, "ADDRESS:PORT")
        self.assert_error(refused("--http-token", tokens), 2, "--http")
        tokens.chmod(0o600)
        service = self.serve("--http-token", tokens, http="0.0.0.0:0")
        self.page = self.page.replace("0.0.0.0", "127.0.0.1")
        self.token = "of-a-viewer-000001"
        self.assertEqual(200, self.get("/")[0])
        self.assertEqual(200, self.get("/healthz")[0])
        job = self.submit()
        for path in ("/metrics", "/api/v1/farm", f"/api/v1/jobs/{job}/preview.png"):
            self.assertEqual(401, self.get(path)[0], path)
            self.assertEqual(401, self.get(path, token="of-a-viewer-000002")[0], path)
            self.assertIn(self.get(path, token="of-a-viewer-000001")[0], (200, 204), path)
        order = f"/api/v1/jobs/{job}/pause"
        self.assertEqual(403, self.get(order, token="of-a-viewer-000001", data={})[0])
        self.assertEqual(200, self.get(order, token="of-a-submitter-001", data={})[0])
        # Another token in its place, without another start; then a file that is wrong.
        tokens.write_text("of-a-viewer-000003 viewer\n")
        service.send_signal(signal.SIGHUP)
        wait_until(lambda: self.get("/metrics", token="of-a-viewer-000003")[0] == 200, "it is let in")
        self.assertEqual(401, self.get("/metrics", token="of-a-viewer-000001")[0])
        tokens.write_text("short viewer\n")
        service.send_signal(signal.SIGHUP)
        time.sleep(0.3)
        self.assertEqual(200, self.get("/metrics", token="of-a-viewer-000003")[0])
        self.stop(service)

    def test_viewers_that_stall_hold_up_nothing(self):
        service, worker = self.serve(), self.worker()
        job = self.submit()
        address = ("127.0.0.1", int(self.page.rstrip("/").rpartition(":")[2]))
        stalled = []
        for i in range(100):
            connection = socket.create_connection(address)
            self.addCleanup(connection.close)
            stalled.append(connection)
            if i % 2:  # the others say nothing at all
                connection.sendall(f"GET /api/v1/jobs/{job}/preview.png HTTP/1.1\r\nHost: localhost\r\n\r\n".encode() * 20)
        wait_until(lambda: self.api(f"jobs/{job}")["state"] == "done", "the job is done")
        farm = self.api("farm")
        metrics = dict(line.rsplit(" ", 1) for line in self.get("/metrics")[1].decode().splitlines()
                       if not line.startswith("#"))
        # Twice a second, and once for the end.
        most = 2 * farm["uptime_seconds"] + 2
        self.assertLessEqual(float(metrics["tessera_web_previews_total"]), most)
        self.assertLessEqual(float(metrics["tessera_web_previews_encoded_total"]), most)
        # And one more for each piece of news: a job, and its first tile.
        self.assertLessEqual(float(metrics["tessera_web_snapshots_total"]), 4 * farm["uptime_seconds"] + 2 + 2)
        self.assertEqual(0, farm["counters"]["workers_lost"])
        self.stop(service, worker)


@unittest.skipUnless(browser.PROGRAM, "NO CHROMIUM: the page itself is not tested; deploy/packages.txt has it")
class Page(WebTest):
    def setUp(self):
        super().setUp()
        self.browser = browser.Page()

    def tearDown(self):
        self.browser.close()
        super().tearDown()

    def open(self):
        self.browser.call("Page.navigate", url=self.page)
        wait_until(lambda: self.browser.evaluate("location.pathname === '/' && document.readyState") == "complete",
                   "the page is loaded")
        return self.browser

    def painted(self, page):
        """The share of the picture's pixels that have a colour."""
        return page.evaluate("""(() => { const film = document.querySelector("#film");
            const bytes = film.getContext("2d").getImageData(0, 0, film.width, film.height).data;
            let lit = 0;
            for (let i = 0; i < bytes.length; i += 4) lit += bytes[i] + bytes[i + 1] + bytes[i + 2] > 0;
            return film.width === 1 ? 0 : lit / (film.width * film.height); })()""")

    def shows(self, page, path):
        """Whether the picture is that of `path`."""
        return page.evaluate("""(async () => { const film = document.querySelector("#film");
            const image = await createImageBitmap(await (await fetch(%s)).blob());
            const other = new OffscreenCanvas(image.width, image.height).getContext("2d");
            other.drawImage(image, 0, 0);
            const bytes = (pen) => pen.getImageData(0, 0, image.width, image.height).data;
            const one = bytes(film.getContext("2d")), two = bytes(other);
            return film.width === image.width && one.every((byte, i) => byte === two[i]); })()""" % json.dumps(path))

    def test_shows_a_running_job_to_its_end_over_a_restart(self):
        self.spp = 64 if SLOWER == 1 else 16
        service = self.serve()
        page = self.open()
        wait_until(lambda: page.evaluate("document.body.dataset.connection") == "live", "the page is live")
        self.assertIn("No job yet", page.text("#no-jobs"))
        job = self.submit("--name", "glass")
        wait_until(lambda: page.text("#job-name") == "glass", "the job shows")
        self.assertEqual(0, self.painted(page))
        worker = self.worker()
        wait_until(lambda: 0 < self.painted(page) < 1, "the picture fills in")
        self.assertEqual("running", page.text("#job-state"))
        wait_until(lambda: "2 threads" in page.text("#summary"), "the worker shows")
        page.click("#pause")
        wait_until(lambda: page.text("#job-state") == "paused", "it pauses the job")
        self.assertEqual("paused", self.api(f"jobs/{job}")["state"])
        done = self.api(f"jobs/{job}")["tiles_done"]
        # Another coordinator takes the first one's place.
        service.send_signal(signal.SIGKILL)
        service.communicate()
        wait_until(lambda: page.evaluate("document.body.dataset.connection") == "lost", "it says that it is cut off")
        self.assertIn("disconnected", page.text("#connection"))
        service = self.serve(http=self.page[len("http://"):].rstrip("/"))
        wait_until(lambda: page.evaluate("document.body.dataset.connection") == "live", "it comes back by itself")
        wait_until(lambda: page.text("#pause") == "Resume", "the job is as it was")
        self.assertLess(done, TILES)
        page.click("#pause")
        wait_until(lambda: page.text("#job-state") == "done", "the job is done")
        wait_until(lambda: self.shows(page, f"/api/v1/jobs/{job}/preview.png"), "the picture shows")
        wait_until(lambda: self.painted(page) > 0.9, "the last of it is fetched and painted")
        self.assertIn(f"{TILES} of {TILES} tiles", page.text("#progress-text"))
        self.assertIn("kept from an earlier run", page.text("#progress-text"))
        wait_until(lambda: "job 1 is done" in page.text("#log").replace(" (glass)", ""), "the log tells")
        page.click("#show-cost")
        wait_until(lambda: not page.evaluate("document.querySelector('#cost-scale').hidden"), "what tiles took")
        self.assertEqual([], page.complaints)
        self.stop(service, worker)

    def test_shows_and_saves_what_has_ended_before(self):
        service, worker = self.serve(), self.worker()
        job = self.submit("--name", "glass")
        wait_until(lambda: self.api(f"jobs/{job}")["state"] == "done", "the job is done")
        page = self.open()
        wait_until(lambda: self.painted(page) > 0.9, "the picture shows")
        wait_until(lambda: not page.evaluate("document.querySelector('#save-picture').hidden"), "it can be saved")
        saved = self.folder / "saved"
        page.call("Page.setDownloadBehavior", behavior="allow", downloadPath=str(saved))
        page.click("#save-picture")
        wait_until((saved / f"job-{job}.png").exists, "the picture is saved")
        self.assertEqual(self.get(f"/api/v1/jobs/{job}/picture.png")[1], (saved / f"job-{job}.png").read_bytes())
        self.assertEqual("", page.text("#order-note"))
        self.assertEqual([], page.complaints)
        # Of one that nobody traces there is none.
        self.stop(worker)
        self.spp += 1  # else its tiles are those of the other job
        self.submit("--name", "none")
        wait_until(lambda: "none" in page.text("#jobs"), "the other job shows")
        page.click("#jobs button")
        wait_until(lambda: page.text("#job-name") == "none", "it is chosen")
        wait_until(lambda: page.evaluate("document.querySelector('#save-picture').hidden"), "there is nothing to save")
        self.stop(service)

    def test_compares_jobs_and_hands_out_their_scenes(self):
        service, worker = self.serve(), self.worker()
        first = self.submit("--name", "one")
        second = self.submit("--name", "two", "--seed", 7)
        same = self.submit("--name", "three")
        for job in (first, second, same):
            wait_until(lambda job=job: self.api(f"jobs/{job}")["state"] == "done", "the job is done")
        page = self.open()
        page.evaluate(f"location.hash = '#job={first}'")
        page.call("Page.reload")
        wait_until(lambda: page.text("#job-name") == "one", "the job shows")

        def compared(other):
            page.evaluate(f"""(() => {{ const list = document.querySelector("#other"); list.value = "{other}";
                              list.dispatchEvent(new Event("change")); }})()""")
            return wait_until(lambda: (text := page.text("#difference")).startswith(f"job {first} and job {other}: ")
                              and text, "the numbers show")
        self.assertIn("max difference 0 · mean difference 0 · rmse 0 · differing pixels 0 of", compared(same))
        shown = compared(second)
        for job in (first, second):
            (self.folder / f"{job}.png").write_bytes(self.get(f"/api/v1/jobs/{job}/picture.png")[1])
        told = self.run_program("compare", f"{first}.png", f"{second}.png").out
        for name in ("max difference", "mean difference", "rmse"):
            number = float(re.search(rf"{name} +(\S+)", told)[1])
            self.assertGreater(number, 0)
            self.assertAlmostEqual(number, float(re.search(rf"{name} (\S+)", shown)[1]), delta=number * 1e-4)
        self.assertIn("differing pixels " + re.search(r"differing pixels +(\d+ of \d+)", told)[1], shown)
        # The scene that is handed out is the one that was rendered.
        saved = self.folder / "saved"
        page.call("Page.setDownloadBehavior", behavior="allow", downloadPath=str(saved))
        wait_until(lambda: not page.evaluate("document.querySelector('#save-scene').hidden"), "it can be saved")
        page.click("#save-scene")
        wait_until((saved / f"job-{first}.tessera").exists, "the scene is saved")
        self.assertIn(f"tessera studio job-{first}.tessera", page.text("#open-scene"))
        digests = [json.loads(self.run_program("info", scene, "--json").out)["scene"]
                   for scene in (self.scene, saved / f"job-{first}.tessera")]
        self.assertEqual(digests[0], digests[1])
        # It opens as a text that can be changed.
        own = {name: str(self.folder / name) for name in ("XDG_STATE_HOME", "XDG_CONFIG_HOME")}
        with Studio(PROGRAM, saved, "--workers", "1", env={**self.environment(), **own}) as studio:
            opened = studio.connect()
            opened.say("open", file=f"job-{first}.tessera")
            document = opened.receive("document")
            self.assertTrue(document["editable"], document)
            self.assertIn('name: "mirror"', document["text"])
            opened.close()
        self.assertEqual([], page.complaints)
        self.stop(service, worker)

    def test_signs_in(self):
        tokens = self.write("tokens", "of-a-viewer-000001 viewer\n")
        tokens.chmod(0o600)
        service = self.serve("--http-token", tokens)
        page = self.open()
        wait_until(lambda: page.evaluate("document.querySelector('#sign-in').open"), "it asks for a token")
        page.evaluate("document.querySelector('#token').value = 'of-a-viewer-000001'")
        page.click("#sign-in button")
        wait_until(lambda: page.evaluate("document.body.dataset.connection") == "live", "the page is live")
        self.assertFalse(page.evaluate("document.querySelector('#sign-in').open"))
        self.stop(service)

    def test_fits_a_phone(self):
        service, worker = self.serve(), self.worker()
        page = self.open()
        self.submit("--name", "a-name-that-is-much-too-long-for-any-phone-" * 3)
        page.call("Emulation.setDeviceMetricsOverride", width=360, height=740, deviceScaleFactor=2, mobile=True)
        wait_until(lambda: page.text("#job-state") == "done", "the job is done")
        self.assertLessEqual(page.evaluate("document.documentElement.scrollWidth"), 360)
        self.assertEqual([], page.complaints)
        self.stop(service, worker)


class Timeline(TesseraTest):
    def test_has_every_tile(self):
        scene = self.write("scene.tessera", scenes.ONE_SPHERE)
        result = self.run_program("render", scene, "--size", "64x64", "--tile", 16, "--workers", 2,
                                  "--trace", "trace.json", "--quiet")
        self.assertEqual(0, result.code, result.err)
        events = json.loads((self.folder / "trace.json").read_text())["traceEvents"]
        self.assertEqual({f"tile {i}" for i in range(16)},
                         {event["name"] for event in events if event.get("cat") == "tile"})
        self.assertEqual(["parse", "trace", "write"], [event["name"] for event in events if event.get("cat") == "phase"])
        self.assertTrue(all(event["ts"] >= 0 and event["dur"] >= 0 for event in events if event["ph"] == "X"))
        result = self.run_program("render", scene, "--trace", "t.json", "--connect", "tcp://127.0.0.1:1")
        self.assert_error(result, 2, "--trace", "expected no --connect")


class FakeTev(threading.Thread):
    """Takes a viewer's place: decodes what it is sent into images, or does not read at all."""

    def __init__(self, reads=True):
        super().__init__(daemon=True)
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.connection = None
        self.address = "127.0.0.1:%d" % self.listener.getsockname()[1]
        self.images = {}
        self.trouble = None
        self.reads = reads
        self.start()

    def run(self):
        try:
            self.connection, _ = self.listener.accept()
            while self.reads and (head := self.take(4)):
                self.decode(self.take(struct.unpack("<I", head)[0] - 4))
        except Exception as error:  # told by the test's own thread
            self.trouble = error

    def close(self):
        for end in (self.listener, self.connection):
            if end:
                end.close()

    def take(self, count):
        data = b""
        while len(data) < count:
            part = self.connection.recv(count - len(data))
            if not part:
                return b""
            data += part
        return data

    def decode(self, message):
        kind, focus = message[0], message[1]
        assert focus == 0
        name, rest = self.text(message[2:])
        if kind == 4:
            width, height, channels = struct.unpack_from("<iii", rest)
            names = rest[12:].split(b"\0")
            assert (channels, names) == (3, [b"R", b"G", b"B", b""]), names
            self.images[name] = (width, height, [None] * (width * height))
            return
        assert kind == 6, kind
        channels, rest = struct.unpack_from("<i", rest)[0], rest[4:]
        for expected in ("R", "G", "B"):
            channel, rest = self.text(rest)
            assert channel == expected
        x, y, width, height = struct.unpack_from("<iiii", rest)
        layout = struct.unpack_from("<6q", rest, 16)
        assert (channels, layout) == (3, (0, 1, 2, 3, 3, 3)), layout
        values = struct.unpack_from(f"<{width * height * 3}f", rest, 64)
        assert len(rest) == 64 + 12 * width * height
        columns, _, pixels = self.images[name]
        for row in range(height):
            for column in range(width):
                at = 3 * (row * width + column)
                pixels[(y + row) * columns + x + column] = values[at:at + 3]

    @staticmethod
    def text(data):
        text, _, rest = data.partition(b"\0")
        return text.decode(), rest


class Tev(WebTest):
    def expected_pixels(self):
        """Of the scene, rows from the top."""
        values = struct.unpack("<230400f", self.expected()[-230400 * 4:])
        rows = [values[i * 960:(i + 1) * 960] for i in reversed(range(240))]
        return [row[3 * i:3 * i + 3] for row in rows for i in range(320)]

    def check(self, tev):
        self.assertIsNone(tev.trouble)
        self.assertEqual(1, len(tev.images))
        width, height, pixels = next(iter(tev.images.values()))
        self.assertEqual((320, 240), (width, height))
        self.assertEqual(self.expected_pixels(), pixels)

    def test_shows_what_render_traces(self):
        tev = FakeTev()
        self.addCleanup(tev.close)
        self.render(self.scene, *LOAD, self.spp, "--tev", tev.address)
        tev.join(PATIENCE)
        self.check(tev)

    def test_shows_what_a_farm_traces(self):
        tev = FakeTev()
        self.addCleanup(tev.close)
        service, worker = self.serve("--tev", tev.address), self.worker()
        job = self.submit()
        wait_until(lambda: self.api(f"jobs/{job}")["state"] == "done", "the job is done")
        wait_until(lambda: tev.images and None not in next(iter(tev.images.values()))[2], "all is shown")
        self.check(tev)
        self.stop(service, worker)

    def test_one_that_is_not_there_or_stalls_changes_nothing(self):
        reference = self.render(self.scene, *LOAD, self.spp)["pixels_sha256"]
        closed = socket.create_server(("127.0.0.1", 0))
        address = "127.0.0.1:%d" % closed.getsockname()[1]
        closed.close()
        self.assertEqual(reference, self.render(self.scene, *LOAD, self.spp, "--tev", address)["pixels_sha256"])
        stalled = FakeTev(reads=False)
        self.addCleanup(stalled.close)
        stats = self.render(self.scene, *LOAD, self.spp, "--tev", stalled.address)
        self.assertEqual(reference, stats["pixels_sha256"])

    def test_leaves_this_machine_for_none(self):
        for address in ("10.0.0.1:14158", "example.org:14158", "127.0.0.1", "127.0.0.1:0", "127.0.0.1:99999"):
            result = self.run_program("render", self.scene, "--tev", address, *LOAD, 1)
            self.assert_error(result, 2, "--tev", "of this machine")
