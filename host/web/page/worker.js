// Renders tiles of frames, in memory of its own.
import { Core } from "./frame.js";

let core = null;

onmessage = async ({ data }) => {
  try {
    if (data.open) {
      core = await Core.open(data.open.module, new Uint8Array(data.open.scene));
      postMessage({ opened: data.open.number });
    } else if (core) {
      render(data);
    }
  } catch (error) {
    postMessage({ failed: String(error.message ?? error), number: data.number });
  }
};

/// Renders tiles within some steps together; a tile that they do not reach is given up.
function render({ number, frame, tiles, steps, isChecked }) {
  core.begin(new Uint8Array(frame));
  const area = tiles.reduce((sum, [, , , width, height]) => sum + width * height, 0);
  const pixels = new Uint8ClampedArray(4 * area);
  const hashes = [];
  let [at, left, spent, rays, unfinished] = [0, steps, 0, 0, 0];
  for (const tile of tiles) {
    // One step is too few for any sample: 0 would be no limit.
    const done = core.render(tile, steps === 0 ? 0 : Math.max(1, left));
    pixels.set(done.pixels, at);
    at += done.pixels.length;
    if (isChecked) hashes.push(core.hash());
    left -= done.steps;
    spent += done.steps;
    rays += done.rays;
    unfinished += done.isWhole ? 0 : 1;
  }
  postMessage({ number, tiles, pixels, hashes, steps: spent, rays, unfinished }, [pixels.buffer]);
}
