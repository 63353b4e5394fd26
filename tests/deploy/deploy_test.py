#!/usr/bin/env python3
"""What deploy/ holds: each command line is one that the program takes, names and ports agree, and
the scripts do what they say, by stand-ins for Slurm and Kubernetes."""
import json
import os
import pathlib
import re
import shlex
import shutil
import signal
import subprocess
import sys
import unittest
import urllib.error
import urllib.request

import yaml

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/cli"))
from slurm_farm import tiles_done, tiles_kept  # noqa: E402
from tessera_process import PROGRAM, TesseraTest, is_worker, marked_processes, wait_until  # noqa: E402

DEPLOY = ROOT / "deploy"
COMMANDS = {"render", "serve", "worker", "keygen", "submit", "status", "pause", "resume", "cancel",
            "fetch", "convert", "info", "compare"}
HTTP, CONTROL, BULK = 7180, 7117, 7118


def documents(path):
    return [document for document in yaml.safe_load_all(path.read_text()) if document]


def yaml_files():
    return sorted(path for path in DEPLOY.rglob("*.y*ml"))


def kubernetes():
    """All objects of Kubernetes, by kind and name; worker/pod.yaml is what all workers are."""
    return {(o["kind"], o.get("metadata", {}).get("name"), path.parent.name): o
            for path in sorted((DEPLOY / "kubernetes").rglob("*.yaml")) for o in documents(path)}


def containers():
    """(pod, container) of all pods that are whole."""
    for (kind, _, folder), found in kubernetes().items():
        pod = found.get("spec", {}).get("template", {}).get("spec", {})
        if kind in ("StatefulSet", "Deployment", "Job"):
            for container in pod.get("initContainers", []) + pod.get("containers", []):
                yield pod, container


def compose():
    return documents(DEPLOY / "compose/compose.yaml")[0]


def option(arguments, name):
    """The value of --name, however it is written."""
    for i, argument in enumerate(arguments):
        if argument == name:
            return arguments[i + 1]
        if argument.startswith(name + "="):
            return argument[len(name) + 1:]
    raise AssertionError(f"no {name} in {arguments}")


def unit_command(path):
    """ExecStart of a systemd unit, with what its variables are where nobody sets them."""
    text = path.read_text()
    values = dict(pair.split("=", 1) for line in re.findall(r"^Environment=(.*)$", text, re.M)
                  for pair in shlex.split(line))
    values |= {"STATE_DIRECTORY": "/state", "CACHE_DIRECTORY": "/cache",
               "CREDENTIALS_DIRECTORY": "/keys"}
    line = re.search(r"^ExecStart=(.*)$", text, re.M)[1].replace("$OPTIONS", "").replace("%i", "farm")
    return shlex.split(re.sub(r"\$\{(\w+)\}", lambda found: values[found[1]], line))


def shell_commands(script):
    """Lines that start our program."""
    for line in script.replace("\\\n", " ").splitlines():
        words = shlex.split(line.strip().removeprefix("$ ").removeprefix("exec "), comments=True)
        if len(words) > 1 and words[0] == "tessera" and words[1] in COMMANDS:
            end = next((i for i, word in enumerate(words) if word[0] in ">|&"),
                       len(words))
            yield words[:end]


def markdown_commands(path):
    for block in re.findall(r"```\w*\n(.*?)```", path.read_text(), re.S):
        yield from shell_commands(block)


def command_lines():
    """(where, arguments) of all that is written down; scripts are run instead."""
    for path in sorted((DEPLOY / "systemd").glob("*.service")):
        yield path.name, unit_command(path)[1:]
    for name, service in compose()["services"].items():
        if name in ("keys", "worker"):
            for words in shell_commands(service["command"][0]):
                yield f"compose {name}", words[1:]
        elif service["image"].startswith("tessera:") and name != "client":
            yield f"compose {name}", shlex.split(service["command"])
    for _, container in containers():
        yield f"kubernetes {container['name']}", [
            argument.replace("$(THREADS)", "4").replace("$(POD)", "worker-x") for argument in
            container["args"]]
    for document in ("docs/deploy.md", "docs/security.md"):
        for words in markdown_commands(ROOT / document):
            yield document, words[1:]


class CommandLines(TesseraTest):
    def test_each_is_taken_by_the_program(self):
        """One option too many is all that the program finds wrong with each."""
        count = 0
        for where, arguments in command_lines():
            with self.subTest(where=where, arguments=arguments):
                refused = self.run_program(*arguments, "--no-such-option")
                self.assert_error(refused, 2, "'--no-such-option' is no option")
                count += 1
        self.assertGreater(count, 8)

    def test_no_two_machines_share_a_workers_key(self):
        """Each command that makes a worker's key makes it on the machine that has it, or makes one
        for each; and what a worker is given of others is no key."""
        enrols = [arguments for _, arguments in command_lines() if "--enrol" in " ".join(arguments)]
        self.assertGreaterEqual(len(enrols), 3)  # compose, Kubernetes, docs
        for where, arguments in command_lines():
            if arguments[0] == "keygen":
                with self.subTest(where=where, arguments=arguments):
                    self.assertFalse("--role" in arguments and option(arguments, "--role") == "worker"
                                     and "--tokens" not in arguments)
        # Compose: the key lies in a volume without a name, which is one container's.
        worker = compose()["services"]["worker"]
        key = option(next(words for words in shell_commands(worker["command"][0])
                          if words[1] == "worker"), "--key")
        self.assertIn(str(pathlib.Path(key).parent), worker["volumes"])
        # Kubernetes: in a volume that is as old as the pod, and tokens reach no other container.
        for pod, container in containers():
            if container["name"] not in ("worker", "enrol"):
                continue
            volumes = {volume["name"]: volume for volume in pod["volumes"]}
            mounts = {mount["mountPath"]: mount["name"] for mount in container["volumeMounts"]}
            key = (option(container["args"], "--key") if container["name"] == "worker" else
                   container["args"][1])
            self.assertIn("emptyDir", volumes[mounts[str(pathlib.Path(key).parent)]])
            self.assertEqual(container["name"] == "enrol", "tokens" in mounts.values())
        self.assertIn("--name=$(POD)", next(c for _, c in containers() if c["name"] == "enrol")["args"])

    def test_one_that_is_wrong_is_found(self):
        for wrong in (["serve", "--stroe", "x"], ["worker", "--connect=tcp://a:1", "--threads=no"]):
            refused = self.run_program(*wrong, "--no-such-option")
            self.assertNotIn("'--no-such-option' is no option", refused.err)

    def test_the_manual_page_has_every_command(self):
        page = (DEPLOY / "debian/tessera.1").read_text()
        told = re.findall(r"^  (\w+) ", self.run_program("--help").out.split("Subcommands:")[1], re.M)
        self.assertGreater(len(told), 10)
        for command in told:
            self.assertRegex(page, rf"\b{command}\b")


class Files(TesseraTest):
    def test_all_yaml_and_json_is_read(self):
        self.assertGreater(len(yaml_files()), 10)
        for path in yaml_files():
            with self.subTest(path=path.name):
                self.assertTrue(documents(path))
        for path in DEPLOY.rglob("*.json"):
            with self.subTest(path=path.name):
                json.loads(path.read_text())

    def scripts(self):
        """Those of the shell."""
        of_ci = [path for path in (ROOT / ".ci").iterdir() if path.read_text().startswith("#!/usr/bin/env bash\n")]
        return [*DEPLOY.rglob("*.sh"), *DEPLOY.rglob("*.sbatch"), *of_ci]

    def test_the_copyright_file_names_what_is_linked(self):
        uses = [line.split() for line in (DEPLOY / "packages.txt").read_text().splitlines() if not line.startswith("#")]
        # Python's own: only a module for it is made.
        linked = {name for name, use in uses if use == "build" and name.endswith("-dev")} - {"python3-dev"}
        stanzas = (DEPLOY / "debian/copyright").read_text().split("\n\n")
        stated = {}
        for stanza in stanzas:
            if found := re.search(r"^Files: (.*?)^Copyright: .*?^License: (.*?)$", stanza, re.M | re.S):
                stated |= {name: found[2] for name in found[1].split()}
        self.assertEqual(set(), linked - set(stated))
        texts = {stanza.partition("\n")[0].removeprefix("License: ") for stanza in stanzas if stanza.startswith("License: ")}
        self.assertEqual(set(stated.values()), texts, "each licence has its text")

    def test_scripts_are_sound(self):
        scripts = [str(path) for path in self.scripts()]
        self.assertEqual(0, subprocess.run(["bash", "-n", *scripts]).returncode)
        if not shutil.which("shellcheck"):
            self.skipTest("shellcheck is not installed")
        checked = subprocess.run(["shellcheck", "--external-sources", "--shell=bash",
                                  f"--source-path={ROOT}:SCRIPTDIR", *scripts], capture_output=True, text=True)
        self.assertEqual(0, checked.returncode, checked.stdout)

    def test_units_are_sound(self):
        if not shutil.which("systemd-analyze"):
            self.skipTest("systemd-analyze is not installed")
        for unit in (DEPLOY / "systemd").glob("*.service"):
            name = unit.name.replace("@", "@farm")
            copy = self.write(name, unit.read_text().replace("/usr/bin/tessera", PROGRAM))
            checked = subprocess.run(["systemd-analyze", "verify", "--man=no", copy],
                                     capture_output=True, text=True)
            about = [line for line in checked.stderr.splitlines() if name in line]
            self.assertEqual([], about)


class Kubernetes(TesseraTest):
    def pod(self, name):
        return next(pair for pair in containers() if pair[1]["name"] == name)

    def test_ports_agree(self):
        pod, coordinator = self.pod("coordinator")
        arguments = coordinator["args"]
        ports = {port["name"]: port["containerPort"] for port in coordinator["ports"]}
        self.assertEqual({"control": CONTROL, "bulk": BULK, "http": HTTP}, ports)
        self.assertEqual(f"tcp://0.0.0.0:{CONTROL}", option(arguments, "--bind"))
        self.assertTrue(option(arguments, "--http").endswith(f":{HTTP}"))
        service = kubernetes()["Service", "tessera", "base"]["spec"]
        self.assertEqual(ports, {port["name"]: port["port"] for port in service["ports"]})
        for port in service["ports"]:
            self.assertIn(port["targetPort"], ports)
        _, worker = self.pod("worker")
        self.assertEqual(f"tcp://tessera:{CONTROL}", option(worker["args"], "--connect"))
        for probe in ("startupProbe", "livenessProbe", "readinessProbe"):
            self.assertIn(coordinator[probe]["httpGet"]["path"], ("/healthz", "/readyz"))
            self.assertEqual("http", coordinator[probe]["httpGet"]["port"])
        trigger = kubernetes()["ScaledObject", "worker", "autoscaled"]["spec"]["triggers"][0]
        self.assertEqual(f"http://tessera.tessera.svc:{HTTP}/metrics", trigger["metadata"]["url"])
        login = kubernetes()["TriggerAuthentication", "tessera-metrics", "autoscaled"]
        self.assertEqual(login["metadata"]["name"], trigger["authenticationRef"]["name"])
        self.assertEqual({"parameter": "token", "name": "tessera-metrics", "key": "token"},
                         login["spec"]["secretTargetRef"][0])

    def test_who_may_speak_to_the_coordinator(self):
        policies = {name: found["spec"] for (kind, name, _), found in kubernetes().items()
                    if kind == "NetworkPolicy"}
        for name, spec in policies.items():
            self.assertEqual(name, spec["podSelector"]["matchLabels"]["app.kubernetes.io/component"])
            self.assertEqual(["Ingress", "Egress"], spec["policyTypes"])
        farm = [{"port": CONTROL}, {"port": BULK}]
        self.assertEqual([farm, [{"port": HTTP}]],
                         [rule["ports"] for rule in policies["coordinator"]["ingress"]])
        self.assertEqual(farm, policies["worker"]["egress"][0]["ports"])
        self.assertEqual([], policies["worker"]["ingress"])

    def test_pods_are_held_tightly_and_have_their_keys(self):
        secrets = self.secrets()
        for name in ("coordinator", "worker", "enrol"):
            pod, container = self.pod(name)
            self.assertTrue(pod["securityContext"]["runAsNonRoot"])
            self.assertFalse(pod["automountServiceAccountToken"])
            self.assertEqual({"drop": ["ALL"]}, container["securityContext"]["capabilities"])
            self.assertTrue(container["securityContext"]["readOnlyRootFilesystem"])
            self.assertGreaterEqual(pod["terminationGracePeriodSeconds"], 15)
            volumes = {volume["name"]: volume for volume in pod["volumes"]}
            for mount in container["volumeMounts"]:
                keys = volumes.get(mount["name"], {}).get("secret")
                if not keys:
                    continue
                self.assertEqual(0, keys["defaultMode"] & 0o007)
                wanted = {value.rsplit("/", 1)[1] for value in
                          (a.split("=", 1)[1] for a in container["args"] if "=" in a)
                          if value.startswith(mount["mountPath"])}
                self.assertEqual(secrets[keys["secretName"]], wanted)

    def secrets(self):
        """What make-secrets.sh gives to whom, by a stand-in for kubectl."""
        stand_in = self.write("bin/kubectl", f"""#!/bin/sh
if [ "$1 $2" = "create secret" ]; then
  echo "$*" >>{self.folder}/created
  for word; do case $word in --from-file=*) test -s "${{word##*=}}" || exit 1;; esac; done
fi
""")
        stand_in.chmod(0o755)
        environment = {**self.environment(), "TESSERA": PROGRAM,
                       "PATH": f"{stand_in.parent}:{os.environ['PATH']}"}
        for _ in range(2):  # the second time, the keys are there
            subprocess.run([DEPLOY / "kubernetes/make-secrets.sh", self.folder / "keys"],
                           env=environment, check=True, stdout=subprocess.DEVNULL)
        tokens = (self.folder / "keys/http.tokens").read_text()
        self.assertRegex(tokens, r"^(\w{48}) viewer metrics\n(?!\1)\w{48} submitter page\n$")
        self.assertTrue(tokens.startswith((self.folder / "keys/metrics.token").read_text()))
        allowed = (self.folder / "keys/farm.allow").read_text()
        self.assertRegex(allowed, r"^\w{64} submitter client\n"
                         r"(\w{64} enrol:worker worker-\d+ until=\S+\n){512}$")
        created = [shlex.split(line) for line in (self.folder / "created").read_text().splitlines()]
        self.assertEqual(created[:4], created[4:])
        self.assertIn("--from-file=token=metrics.token", created[3])
        # Other tokens take the place of these, and the client's key stays.
        (self.folder / "keys/worker.tokens").unlink()
        subprocess.run([DEPLOY / "kubernetes/make-secrets.sh", self.folder / "keys"],
                       env=environment, check=True, stdout=subprocess.DEVNULL)
        renewed = (self.folder / "keys/farm.allow").read_text()
        self.assertEqual(513, renewed.count("\n"))
        self.assertEqual({allowed.splitlines()[0]}, set(allowed.splitlines()) & set(renewed.splitlines()))
        return {next(word for word in words if word.startswith("tessera-")):
                {word.partition("=")[2] for word in words if word.startswith("--from-file")}
                for words in created[:4]}

    def write(self, name, content):
        (self.folder / name).parent.mkdir(exist_ok=True)
        return super().write(name, content)

    def test_schemas(self):
        modules, kubectl = os.environ.get("TESSERA_KUBERNETES_MODELS"), shutil.which("kubectl")
        if not modules or not kubectl:
            self.skipTest("TESSERA_KUBERNETES_MODELS names no folder of schemas "
                          "(docs/notes/deploy_tried.md), or there is no kubectl")
        for folder in ("base", "standing", "autoscaled", "batch"):
            with self.subTest(folder=folder):
                built = subprocess.run([kubectl, "kustomize", DEPLOY / "kubernetes" / folder],
                                       capture_output=True, text=True, check=True).stdout
                checked = subprocess.run(["node", ROOT / "tests/deploy/schemas.mjs", modules],
                                         input=built, capture_output=True, text=True)
                self.assertEqual((0, ""), (checked.returncode, checked.stdout), checked.stderr)


class Compose(TesseraTest):
    def test_services_agree(self):
        services = compose()["services"]
        arguments = shlex.split(services["coordinator"]["command"])
        self.assertEqual(f"tcp://0.0.0.0:{CONTROL}", option(arguments, "--bind"))
        self.assertEqual(f"0.0.0.0:{HTTP}", option(arguments, "--http"))
        self.assertEqual({f"127.0.0.1:{port}:{port}" for port in (CONTROL, BULK, HTTP)},
                         set(services["coordinator"]["ports"]))
        scraped = documents(DEPLOY / "compose/prometheus.yml")[0]["scrape_configs"][0]
        self.assertEqual([f"coordinator:{HTTP}"], scraped["static_configs"][0]["targets"])
        exposed = re.search(r"^EXPOSE (.*)$", (DEPLOY / "containers/Containerfile").read_text(), re.M)[1]
        self.assertEqual({str(port) for port in (CONTROL, BULK, HTTP)}, set(exposed.split()))
        for service in services.values():
            for volume in service.get("volumes", []):
                source = volume.split(":")[0]
                if source.startswith("./"):
                    self.assertTrue((DEPLOY / "compose" / source).exists(), source)
                elif source[0] not in "$/":  # a folder of the user's; a volume without a name
                    self.assertIn(source, compose()["volumes"])

    def test_metrics_that_are_looked_at_are_there(self):
        looked_at = {name for path in DEPLOY.rglob("*") if path.suffix in (".json", ".yaml")
                     for name in re.findall(r"\btessera_\w+", path.read_text())}
        self.assertGreater(len(looked_at), 10)
        service = self.start("serve", "--bind", "tcp://127.0.0.1:*", "--http", "127.0.0.1:0")
        service.stdout.readline()
        address = service.stdout.readline().split()[-1]
        def metrics():
            try:
                return urllib.request.urlopen(address + "metrics").read().decode()
            except urllib.error.HTTPError:
                return ""  # it is starting
        there = set(re.findall(r"^(tessera_\w+)", wait_until(metrics, "it has metrics"), re.M))
        self.assertEqual(set(), looked_at - there)
        service.send_signal(signal.SIGTERM)
        service.wait(60)

    def script(self, service, **places):
        """That of a service, with its folders in the test's."""
        script = compose()["services"][service]["command"][0].replace("$$", "$")
        for place, folder in places.items():
            (self.folder / folder).mkdir(exist_ok=True)
            script = script.replace("/" + place.replace("_", "/"), str(self.folder / folder))
        return script

    def shell(self, script):
        environment = {**self.environment(),
                       "PATH": f"{pathlib.Path(PROGRAM).parent}:{os.environ['PATH']}"}
        return subprocess.Popen(["sh", "-euc", script], env=environment, text=True,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE)

    def make_keys(self):
        made = self.shell(self.script("keys", etc_tessera="keys", etc_worker="enrol",
                                      etc_client="client", etc_scrape="scrape"))
        self.assertEqual(0, made.wait(60), made.communicate())
        made.communicate()
        return {str(p.relative_to(self.folder)): p.read_text() for p in self.folder.rglob("*")
                if p.is_file()}

    def test_keys_are_made_once(self):
        made = [self.make_keys() for _ in range(2)]
        self.assertEqual(made[0], made[1])
        self.assertEqual({"keys/farm.key", "keys/farm.pub", "keys/client.pub", "keys/farm.allow",
                          "keys/http.tokens", "enrol/farm.pub", "enrol/worker.tokens",
                          "client/farm.pub", "client/client.key", "scrape/token"}, set(made[0]))
        self.assertRegex(made[0]["keys/http.tokens"],
                         rf"^{made[0]['scrape/token']} viewer prometheus\n\w{{48}} submitter page\n$")
        self.assertEqual(0o600, (self.folder / "keys/http.tokens").stat().st_mode & 0o777)

    def test_each_worker_has_a_key_of_its_own(self):
        self.make_keys()
        service = self.start("serve", "--bind", "tcp://127.0.0.1:*", "--store", "store", "--key",
                             "keys/farm.key", "--allow", "keys/farm.allow")
        address = service.stdout.readline().split()[-1]
        enrolled = self.folder / "store/enrolled.allow"
        def lines():
            return enrolled.read_text().splitlines() if enrolled.exists() else []
        workers = []
        for count, own in ((1, "one"), (2, "two"), (2, "two")):  # the last is started again
            script = self.script("worker", etc_worker="enrol", var_lib_tessera=own,
                                 var_cache_tessera="cache")
            # All containers here have one machine's name.
            script = script.replace("tcp://coordinator:7117", address).replace(
                "--enrol", f"--name {own} --enrol")
            workers.append(self.shell(script))
            for line in workers[-1].stderr:
                if "connecting to" in line:
                    break
            self.assertEqual(count, len(lines()))
            if len(workers) == 2:
                workers[1].terminate()
                workers[1].communicate(timeout=60)
        self.assertEqual(["one", "two"], [line.split()[2] for line in lines()])
        self.assertEqual(2, len({line.split()[0] for line in lines()}))
        service.send_signal(signal.SIGTERM)
        service.wait(60)
        for worker in workers:
            worker.communicate(timeout=60)


class Slurm(TesseraTest):
    """The batch script, by stand-ins for srun and scontrol; slurm_test.py has the real ones."""

    def setUp(self):
        super().setUp()
        self.bin = self.folder / "bin"
        self.bin.mkdir()
        # The step's own options come before the program.
        self.stand_in("srun", """
            tasks=$SLURM_NTASKS
            while case $1 in --*) true;; *) false;; esac; do
              [[ $1 != --ntasks=1 ]] || tasks=1
              shift
            done
            export SLURM_PROCID=0
            ((tasks > 1)) || exec "$@"
            trap 'kill $(jobs -p)' TERM
            for ((; SLURM_PROCID < tasks; ++SLURM_PROCID)); do "$@" & done
            wait
            wait""")
        self.stand_in("scontrol", f'echo "$*" >>{self.folder}/scontrol')
        self.scene = ROOT / "scenes/samples/knot.tessera"
        self.size = ["--size", "240x136", "--spp", "8"]

        self.cache = self.temporary / f"tessera-cache-{os.getuid()}"

    def tearDown(self):
        shutil.rmtree(self.cache)  # for the node's next job
        super().tearDown()

    def stand_in(self, name, body):
        (self.bin / name).write_text(f"#!/bin/bash\n{body}\n")
        (self.bin / name).chmod(0o755)

    def batch(self):
        environment = {**self.environment(), "PATH": f"{self.bin}:{os.environ['PATH']}",
                       "SLURM_JOB_ID": "42", "SLURMD_NODENAME": "127.0.0.1", "SLURM_NTASKS": "2",
                       "TESSERA": PROGRAM}
        process = subprocess.Popen(
            ["bash", str(DEPLOY / "slurm/tessera.sbatch"), str(self.scene), "knot.pfm", *self.size],
            cwd=self.folder, env=environment, text=True, stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.addCleanup(self.end, process)
        return process

    def reference(self):
        self.render(self.scene, "-o", "expected.pfm", *self.size)
        return (self.folder / "expected.pfm").read_bytes()

    def test_it_renders_and_tidies_up(self):
        batch = self.batch()
        out, _ = batch.communicate(timeout=300)
        self.assertEqual(0, batch.returncode, out)
        self.assertEqual(self.reference(), (self.folder / "knot.pfm").read_bytes())
        self.assertFalse((self.folder / "tessera-42").exists())
        self.assertFalse((self.folder / "scontrol").exists())

    def test_its_time_over_it_asks_to_be_queued_again_and_goes_on(self):
        self.size[-1] = "256"
        batch = self.batch()
        wait_until(lambda: self.tiles_done() > 20 or batch.poll() is not None, "tiles are finished")
        batch.send_signal(signal.SIGUSR1)
        out, _ = batch.communicate(timeout=300)
        self.assertEqual(0, batch.returncode, out)
        self.assertEqual("requeue 42\n", (self.folder / "scontrol").read_text())
        kept = tiles_kept(self.folder / "tessera-42")
        self.assertGreater(kept, 20)
        again = self.batch()
        out, _ = again.communicate(timeout=300)
        self.assertEqual(0, again.returncode, out)
        self.assertIn(f" {kept} kept from an earlier run", out)
        self.assertEqual(self.reference(), (self.folder / "knot.pfm").read_bytes())

    def test_each_node_has_a_key_of_its_own(self):
        self.size[-1] = "256"
        batch = self.batch()
        wait_until(lambda: self.tiles_done() > 4 or batch.poll() is not None, "tiles are finished")
        lines = (self.folder / "tessera-42/keys/farm.allow").read_text().splitlines()
        self.assertEqual(["client", "worker-0", "worker-1"], [line.split()[2] for line in lines])
        commands = [pathlib.Path(f"/proc/{process}/cmdline").read_text().split("\0")
                    for process in marked_processes(self.mark) if is_worker(process)]
        keys = {option(words, "--key").rsplit("/", 1)[1] for words in commands if words[1:2] == ["worker"]}
        self.assertEqual({"worker-0.key", "worker-1.key"}, keys)
        batch.send_signal(signal.SIGTERM)
        out, _ = batch.communicate(timeout=300)
        self.assertEqual(143, batch.returncode, out)

    def test_a_cache_that_is_not_ours_is_left_alone(self):
        for squat in ("a link", "a file"):
            with self.subTest(squat):
                elsewhere = self.folder / "elsewhere"
                elsewhere.mkdir(exist_ok=True)
                if squat == "a link":
                    self.cache.symlink_to(elsewhere)
                else:
                    self.cache.write_text("squatted")
                batch = self.batch()
                out, _ = batch.communicate(timeout=300)
                self.cache.unlink()
                self.assertEqual(0, batch.returncode, out)
                self.assertEqual([], list(elsewhere.iterdir()))
        self.cache.mkdir()  # for tearDown

    def test_a_coordinator_that_is_killed_is_started_again(self):
        self.size[-1] = "256"
        batch = self.batch()
        wait_until(lambda: self.tiles_done() > 20 or batch.poll() is not None, "tiles are finished")
        [serve] = [process for process in marked_processes(self.mark)
                   if b"serve" in pathlib.Path(f"/proc/{process}/cmdline").read_bytes().split(b"\0")]
        os.kill(serve, signal.SIGKILL)
        out, _ = batch.communicate(timeout=300)
        self.assertEqual(0, batch.returncode, out)
        self.assertEqual(self.reference(), (self.folder / "knot.pfm").read_bytes())

    def tiles_done(self):
        return tiles_done(self, self.folder / "tessera-42", "127.0.0.1")

    def test_a_wrong_scene_is_told(self):
        self.scene = self.write("broken.tessera", "nodes { shpe {} }")
        batch = self.batch()
        out, _ = batch.communicate(timeout=300)
        self.assertEqual(1, batch.returncode, out)
        self.assertIn("'shpe' is no field", out)


if __name__ == "__main__":
    unittest.main()
