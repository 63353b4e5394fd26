#!/usr/bin/env python3
"""The batch script under a real Slurm: munged, slurmctld and slurmd of this test's own, on loopback.

Opt-in: TESSERA_TEST_SLURM=1, as root, with Debian's slurm-wlm and munge."""
import os
import pathlib
import re
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/cli"))
from slurm_farm import tiles_done, tiles_kept  # noqa: E402
from tessera_process import PROGRAM, TesseraTest, wait_until  # noqa: E402

NEEDED = ("munged", "slurmctld", "slurmd", "sbatch", "scontrol", "squeue")


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


class Cluster:
    """One machine, from a folder that only root may look into."""

    def __init__(self, folder):
        self.folder, self.processes = folder, []
        self.environment = {**os.environ, "SLURM_CONF": str(folder / "slurm.conf")}
        host = socket.gethostname().split(".")[0]
        for name in ("state", "spool"):
            (folder / name).mkdir()
        key = folder / "munge.key"
        key.write_bytes(os.urandom(1024))
        key.chmod(0o400)
        (folder / "slurm.conf").write_text(f"""
ClusterName=tessera
SlurmctldHost={host}(127.0.0.1)
CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
SlurmUser=root
SlurmctldPort={free_port()}
SlurmdPort={free_port()}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket,cred_expire=5
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerParameters=batch_sched_delay=1,sched_interval=2
MpiDefault=none
ReturnToService=2
KillWait=30
NodeName={host} NodeAddr=127.0.0.1 CPUs={os.cpu_count()} State=UNKNOWN
PartitionName=farm Nodes=ALL Default=YES MaxTime=INFINITE State=UP
""")

    def start(self):
        f = self.folder
        self.run("munged", "--foreground", f"--socket={f}/munge.socket", f"--key-file={f}/munge.key",
                 f"--pid-file={f}/munged.pid", f"--log-file={f}/munged.log", f"--seed-file={f}/seed",
                 "--force", "--num-threads=2")
        wait_until((f / "munge.socket").exists, "munged listens")
        self.run("slurmctld", "-D")
        wait_until(lambda: self.ask("scontrol", "ping").returncode == 0, "slurmctld answers")
        self.run("slurmd", "-D")
        wait_until(lambda: "idle" in self.ask("sinfo", "--noheader", "--format=%T").stdout,
                   "the node is idle")

    def run(self, program, *arguments):
        with open(self.folder / f"{program}.out", "w") as log:
            self.processes.append(subprocess.Popen([shutil.which(program), *arguments], stdout=log,
                                                   stderr=log, env=self.environment))

    def ask(self, *command):
        return subprocess.run(command, capture_output=True, text=True, env=self.environment)

    def stop(self):
        for process in reversed(self.processes):
            process.terminate()
            try:
                process.wait(30)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


class SlurmTest(TesseraTest):
    def setUp(self):
        super().setUp()
        missing = [program for program in NEEDED if not shutil.which(program)]
        if os.environ.get("TESSERA_TEST_SLURM") != "1" or os.geteuid() != 0 or missing:
            self.skipTest("Slurm is run where TESSERA_TEST_SLURM=1, as root, with slurm-wlm and munge; "
                          f"missing: {missing}")
        private = pathlib.Path(tempfile.mkdtemp(prefix="tessera-slurm-"))
        self.addCleanup(shutil.rmtree, private, ignore_errors=True)
        self.cluster = Cluster(private)
        self.addCleanup(self.cluster.stop)
        self.cluster.start()
        self.scene = ROOT / "scenes/samples/knot.tessera"

    def tearDown(self):
        self.wait_for_the_node()  # a job is said to be completed before its last process has ended
        shutil.rmtree(self.temporary / f"tessera-cache-{os.getuid()}")  # for the node's next job
        super().tearDown()

    def environment(self):
        return {**super().environment(), "SLURM_CONF": str(self.cluster.folder / "slurm.conf")}

    def submit(self, spp, *options):
        """Two workers on the one node; the job's number."""
        done = subprocess.run(
            ["sbatch", "--parsable", "--ntasks-per-node=2", "--output=slurm.log", *options,
             ROOT / "deploy/slurm/tessera.sbatch", self.scene, "knot.pfm", "--size", "480x270",
             "--spp", str(spp)],
            cwd=self.folder, env={**self.environment(), "TESSERA": PROGRAM}, capture_output=True,
            text=True)
        self.assertEqual(0, done.returncode, done.stderr)
        self.farm = self.folder / f"tessera-{done.stdout.strip()}"
        return done.stdout.strip()

    def state(self, job):
        told = self.cluster.ask("scontrol", "--oneliner", "show", "job", job).stdout
        return dict(part.split("=", 1) for part in told.split() if "=" in part)

    def wait_for(self, job, *states):
        wait_until(lambda: time.sleep(.1) or self.state(job)["JobState"] in states, states)

    def wait_for_the_node(self):
        wait_until(lambda: time.sleep(.1) or
                   self.cluster.ask("sinfo", "--noheader", "--format=%T").stdout.strip() == "idle", "the node is free")

    def log(self):
        return (self.folder / "slurm.log").read_text()

    def assert_right(self, job, spp):
        wait_until(lambda: time.sleep(.1) or
                   self.state(job)["JobState"] in ("COMPLETED", "FAILED", "CANCELLED"), "the job ends")
        self.assertEqual("COMPLETED", self.state(job)["JobState"], self.log())
        self.render(self.scene, "-o", "expected.pfm", "--size", "480x270", "--spp", spp)
        self.assertEqual((self.folder / "expected.pfm").read_bytes(),
                         (self.folder / "knot.pfm").read_bytes())
        self.assertFalse(self.farm.exists(), "tidied up")

    def running(self, tiles):
        """Waits for the farm to have finished more tiles than that."""
        wait_until(lambda: time.sleep(.1) or
                   tiles_done(self, self.farm, "127.0.0.1") > tiles, "tiles are finished")

    def test_a_job_is_rendered(self):
        job = self.submit(4)
        self.assert_right(job, 4)
        self.assertRegex(self.log(), r"(?m)(\d+) of \1 tiles$")
        self.assertEqual(2, self.log().count("connected, with"), self.log())

    def test_requeued_it_traces_no_finished_tile_again(self):
        job = self.submit(200)
        self.running(20)
        requeued = self.cluster.ask("scontrol", "requeue", job)
        self.assertEqual(0, requeued.returncode, requeued.stderr)
        self.wait_for(job, "PENDING")
        self.wait_for_the_node()
        kept = tiles_kept(self.farm)
        self.assertGreater(kept, 20)
        self.assert_right(job, 200)
        # How many tiles there are depends on the workers that were there when it began.
        told = re.search(rf"(\d+) of \1 tiles, {kept} kept from an earlier run", self.log())
        self.assertTrue(told, self.log())
        self.assertLess(kept, int(told[1]))

    def test_its_time_over_it_is_queued_again_by_itself(self):
        job = self.submit(200)
        self.running(20)
        signalled = self.cluster.ask("scancel", "--batch", "--signal=USR1", job)
        self.assertEqual(0, signalled.returncode, signalled.stderr)
        wait_until(lambda: time.sleep(.1) or self.state(job).get("Restarts") == "1", "requeued")
        self.assert_right(job, 200)
        self.assertRegex(self.log(), r"(\d+) of \1 tiles, [1-9]\d+ kept from an earlier run")

    def test_cancelled_it_stays_so_and_leaves_nothing_running(self):
        job = self.submit(200)
        self.running(20)
        self.cluster.ask("scancel", job)
        self.wait_for(job, "CANCELLED")
        self.assertEqual("0", self.state(job)["Restarts"])
        self.assertGreater(tiles_kept(self.farm), 20)


if __name__ == "__main__":
    unittest.main()
