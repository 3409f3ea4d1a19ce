// Renders the frames of a desk's record as the page plays them, and compares their hashes.
import fs from "node:fs";
import path from "node:path";

const [, , page, program, file] = process.argv;
const { Core, WALLS, encode, tiles, wallPicture } = await import(path.join(page, "frame.js"));
const { readRecord, seen } = await import(path.join(page, "record.js"));
const module = await WebAssembly.compile(fs.readFileSync(path.join(page, `${program}.wasm`)));
const core = await Core.open(module, new Uint8Array(fs.readFileSync(path.join(page, "animal.shisen"))));
const { sessions: [{ setup, frames }] } = readRecord(core, new Uint8Array(fs.readFileSync(file)));
let [cut, low] = [0, 0];
for (const [number, frame] of frames.entries()) {
  const { eye, forward, up, left } = seen(frame, setup);
  const pictures = WALLS.map((wall, at) => wallPicture(wall, eye, setup.pictures[at].size));
  core.begin(encode({ detail: "foveated", samples: 4, pictures, gaze: { place: eye, forward, up }, ...left }));
  const hashes = tiles(pictures).map((tile) => {
    core.render(tile);
    return core.hash();
  });
  core.wallHashes(pictures, hashes).forEach(({ hash }, at) => {
    if (hash !== frame.hashes[at]) throw new Error(`frame ${number}: ${setup.pictures[at].name} is not the desk's`);
  });
  cut += left.cuts.length > 0;
  low += frame.rung > 0;
}
if (!(cut > 0 && low > 0)) throw new Error(`${cut} frames were cut off, ${low} had a lower quality: one of each is tested`);
console.log(`${program}: ${frames.length} frames of a desk's record, ${cut} of them cut off, ${low} of a lower quality`);
