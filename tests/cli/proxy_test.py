#!/usr/bin/env python3
"""The pages behind the proxy of docs/operating.md: nginx with TLS, each page below a path."""
import json
import pathlib
import re
import shutil
import socket
import ssl
import subprocess
import unittest
import urllib.error
import urllib.request

import browser
from service_test import ServiceTest, free_port
from tessera_process import PATIENCE, wait_until

NGINX = shutil.which("nginx", path="/usr/sbin:/usr/bin")
EXAMPLE = re.search(r"```nginx\n(.*?)```", (pathlib.Path(__file__).parents[2] / "docs/operating.md").read_text(), re.S)[1]
FRAME = """daemon off; master_process off; pid nginx.pid; error_log stderr; events {{ }}
http {{ access_log off; types {{ }} client_body_temp_path 1; proxy_temp_path 2; fastcgi_temp_path 3;
uwsgi_temp_path 4; scgi_temp_path 5;
{} }}
"""


@unittest.skipUnless(NGINX and shutil.which("openssl"), "NO NGINX: no page is tested behind it; deploy/packages.txt has it")
class Proxy(ServiceTest):
    def proxy(self, farm=1, studio=1):
        """Starts the example before the pages at these ports."""
        subprocess.run(["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-subj", "/CN=localhost",
                        "-keyout", "farm.key", "-out", "farm.pem"], cwd=self.folder, check=True, capture_output=True)
        text = EXAMPLE
        for ours, theirs in (("listen 443", f"listen 127.0.0.1:{self.port}"), ("farm.example", "localhost"),
                             ("127.0.0.1:7180", f"127.0.0.1:{farm}"), ("127.0.0.1:7190", f"127.0.0.1:{studio}"),
                             ("/etc/ssl", str(self.folder))):
            self.assertIn(ours, text)
            text = text.replace(ours, theirs)
        (self.folder / "nginx").mkdir()
        process = subprocess.Popen([NGINX, "-p", str(self.folder / "nginx"), "-c",
                                    str(self.write("nginx.conf", FRAME.format(text)))], stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.stderr.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.terminate)
        def listens():
            self.assertIsNone(process.poll(), "nginx ended")
            with socket.socket() as probe:
                return probe.connect_ex(("127.0.0.1", self.port)) == 0
        wait_until(listens, "nginx listens")

    def setUp(self):
        super().setUp()
        self.port = free_port()
        self.public = f"https://localhost:{self.port}"

    def environment(self):
        return {**super().environment(), "XDG_STATE_HOME": str(self.folder / "state"),
                "XDG_CONFIG_HOME": str(self.folder / "config")}

    def ask_page(self, path, data=None, **headers):
        request = urllib.request.Request(f"{self.public}/tessera/{path}", data=None if data is None else json.dumps(data).encode(),
                                         headers={"Content-Type": "application/json", **headers})
        try:
            with urllib.request.urlopen(request, timeout=PATIENCE, context=ssl._create_unverified_context()) as answer:
                return answer.status
        except urllib.error.HTTPError as error:
            return error.code

    def page(self, url):
        page = browser.Page()
        self.addCleanup(page.close)
        page.call("Security.setIgnoreCertificateErrors", ignore=True)
        page.call("Page.navigate", url=url)
        return page

    def test_orders_of_the_public_page_and_of_no_other_are_taken(self):
        port = free_port()
        service = self.serve("--http", f"127.0.0.1:{port}")
        self.proxy(farm=port)
        job = self.submit()
        wait_until(lambda: self.ask_page(f"api/v1/jobs/{job}") == 200, "the job is known")
        self.assertEqual(200, self.ask_page("page.js"))
        self.assertEqual(403, self.ask_page(f"api/v1/jobs/{job}/pause", {}, Origin=self.public), "it is not known to be ours")
        self.stop(service)
        service = self.serve("--http", f"127.0.0.1:{port}", "--http-origin", self.public + "/tessera")
        self.assertEqual(f"page at {self.public}/tessera/\n", service.stdout.readline())
        wait_until(lambda: self.ask_page(f"api/v1/jobs/{job}") == 200, "the job is known again")
        self.assertEqual(200, self.ask_page(f"api/v1/jobs/{job}/pause", {}, Origin=self.public))
        for other in ("https://evil.example", "https://localhost", f"http://localhost:{self.port}", "null"):
            self.assertEqual(403, self.ask_page(f"api/v1/jobs/{job}/resume", {}, Origin=other), other)
        self.stop(service)

    def test_where_others_may_come_tokens_are_needed(self):
        for options, says in ((["--http-origin", "https://farm.example/"], ["--http-origin", "--http"]),
                              (["--http", "127.0.0.1:0", "--http-origin", "https://farm.example/"], ["--http-token"]),
                              (["--http", "127.0.0.1:0", "--http-origin", "farm.example"], ["'farm.example'", "https://"])):
            self.assert_error(self.run_program("serve", "--bind", self.endpoint, *options), 2, *says)

    @unittest.skipUnless(browser.PROGRAM, "NO CHROMIUM: the page itself is not tested; deploy/packages.txt has it")
    def test_the_farm_page_shows_and_orders(self):
        port = free_port()
        service = self.serve("--http", f"127.0.0.1:{port}", "--http-origin", self.public + "/tessera/",
                             "--http-token", self.tokens())
        self.assertEqual(f"page at {self.public}/tessera/\n", service.stdout.readline())
        self.proxy(farm=port)
        job = self.submit("--name", "glass")
        page = self.page(self.public + "/tessera/#job=1")
        wait_until(lambda: page.evaluate("document.querySelector('#sign-in')?.open === true"), "it asks for a token")
        page.evaluate("document.querySelector('#token').value = 'of-a-submitter-001'")
        page.evaluate("document.querySelector('#sign-in-form').requestSubmit()")
        wait_until(lambda: page.evaluate("document.body.dataset.connection") == "live", "the page is live")
        wait_until(lambda: page.text("#job-name") == "glass", "the job shows")
        page.click("#pause")
        wait_until(lambda: page.text("#job-state") == "paused", "it pauses the job")
        self.assertEqual("paused", self.status(job)["state"])
        self.assertTrue(page.evaluate("document.querySelector('#trace').href").startswith(self.public + "/tessera/api/v1/"))
        self.assertEqual([], page.complaints)
        self.stop(service)

    @unittest.skipUnless(browser.PROGRAM, "NO CHROMIUM: the page itself is not tested; deploy/packages.txt has it")
    def test_the_studio_connects(self):
        port = free_port()
        self.proxy(studio=port)
        studio = self.start("studio", self.folder, "--no-open", "--workers", 1, "--http", f"127.0.0.1:{port}",
                            "--http-origin", self.public + "/studio/")
        address = studio.stdout.readline().split()[-1]
        self.assertTrue(address.startswith(f"{self.public}/studio/#token="), address)
        page = self.page(address)
        wait_until(lambda: page.evaluate("document.body?.innerText.includes('scene.tessera')"), "it lists the folder")
        self.assertEqual([], page.complaints)
        self.stop(studio)

    def tokens(self):
        file = self.write("tokens", "of-a-submitter-001 submitter\n")
        file.chmod(0o600)
        return file
