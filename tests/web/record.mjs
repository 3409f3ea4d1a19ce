// Renders a frame of each scene and detail by the page's program, and writes them as records.
import fs from "node:fs";
import path from "node:path";

const [, , page, program, out] = process.argv;
const { Core, WALLS, encode, tiles, wallPicture } = await import(path.join(page, "frame.js"));
const { writeRecord } = await import(path.join(page, "record.js"));
const module = await WebAssembly.compile(fs.readFileSync(path.join(page, `${program}.wasm`)));
const eye = [0, 0, 0];
const size = 96;
const pictures = WALLS.map((wall) => wallPicture(wall, eye, [size, size]));

for (const [file, detail, forward] of [
  ["animal.shisen", "full", [0, 0, -1]],
  ["animal.shisen", "foveated", [0.9, 0.1, -0.4]],
  ["animal-levels.shisen", "paper", [0.2, -0.7, -0.9]],
  ["gallery.shisen", "full", [0, 0, -1]],
  ["gallery.shisen", "foveated", [0.1, -0.3, -0.9]],
  ["prism.shisen", "full", [0, 0, -1]],
]) {
  const scene = new Uint8Array(fs.readFileSync(path.join(page, file)));
  const core = await Core.open(module, scene);
  const gaze = { place: eye, forward: forward.map(Math.fround), up: [0, 1, 0] };
  const frame = { detail, samples: detail === "foveated" ? 4 : 1, pictures, gaze };
  const hash = core.hashOf(scene).toString(16).padStart(16, "0");
  core.begin(encode(frame));
  const hashes = tiles(pictures).map((tile) => {
    core.render(tile);
    return core.hash();
  });
  const shown = { frame, scene: { desk: file, hash }, size };
  const record = writeRecord(core, shown, core.wallHashes(pictures, hashes));
  const name = `${file}-${detail}.rec`;
  fs.writeFileSync(path.join(out, name), new Uint8Array(await record.arrayBuffer()));
}
