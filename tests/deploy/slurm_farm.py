"""What a farm inside a Slurm job, in its folder tessera-JOBID, is at."""
import contextlib
import json
import sqlite3


def tiles_done(test, farm, host):
    """As its coordinator tells a client with the farm's keys; 0 where it does not answer yet."""
    try:
        port = (farm / "endpoint").read_text().split(":")[-1].strip()
    except OSError:
        return 0
    keys = farm / "keys"
    if not port:
        return 0
    told = test.run_program("status", farm.name.replace("tessera", "slurm"), "--json", "--connect",
                            f"tcp://{host}:{port}", "--key", keys / "client.key",
                            "--server-key", keys / "farm.pub")
    return json.loads(told.out)["tiles"]["done"] if told.code == 0 else 0


def tiles_kept(farm):
    """In the store, once its coordinator is no more."""
    with contextlib.closing(sqlite3.connect(farm / "store/farm.db")) as database:
        return database.execute("SELECT count(*) FROM tiles").fetchone()[0]
