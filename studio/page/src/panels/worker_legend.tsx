import * as state from "../state.js";
import { showsWorkerTiles, workerMarks, workerTiles } from "../view/worker_tiles.js";

/** Which worker has which colour and number, and how many tiles of the pass are its. */
export function WorkerLegend() {
  if (!showsWorkerTiles.value) return null;
  const tiles = workerTiles(state.main)?.list ?? [];
  const counts = new Map<number, number>();
  for (const [, , , , worker] of tiles) counts.set(worker, (counts.get(worker) ?? 0) + 1);
  const names = new Map(state.workers.value.flatMap((each) => (each.id === undefined ? [] : [[each.id, each.name]])));
  const workers = [...new Set([...names.keys(), ...counts.keys()])];
  return (
    <div class="legend worker-legend" role="group" aria-label="Tiles by worker">
      {workers.length === 0 && <span>The workers are not known yet.</span>}
      <ul>
        {workers.map((id) => {
          const { number, colour } = workerMarks.of(id);
          return (
            <li key={id}>
              <i style={{ background: colour }} aria-hidden="true" />
              {`${number} ${names.get(id) ?? `worker ${id}`}`}
              <span class="aside">{counts.has(id) ? `${counts.get(id)} tiles` : ""}</span>
            </li>
          );
        })}
      </ul>
    </div>
  );
}
