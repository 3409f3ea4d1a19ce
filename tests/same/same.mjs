// Renders described frames, and prints a table of how many are what a record has.
//
//   node same.mjs PAGE WORK EFFECTS   in node and in a browser, by the programs of the page in PAGE; each
//                                     folder SCENE-SIZE of WORK is one of `shisen replay --describe`, with
//                                     what a microcontroller printed in a file device, and beside it are
//                                     the reports of `replay --verify`, avx2-SCENE-SIZE and
//                                     portable-SCENE-SIZE; fails where a frame differs, or one of so many
//                                     effects, a spent budget or a moved object is not among them
//   node same.mjs --pack FOLDER       prints the memory of a microcontroller, as
//                                     tests/firmware/src/bin/replay.rs reads it
import fs from "node:fs";
import path from "node:path";
import { openBrowser, serve } from "../web/browser.mjs";
import { described, hashes } from "./hashes.js";

const PROGRAMS = { shisen: "wasm", "shisen-simd": "wasm simd128" };
const PATHS = { avx2: "AVX2", portable: "no vectors" };
const here = import.meta.dirname;
const read = (...parts) => new Uint8Array(fs.readFileSync(path.join(...parts)));
const framesOf = (folder) => fs.readdirSync(folder).filter((name) => name.endsWith(".frame")).sort();

function pack(folder) {
  const scene = read(folder, "scene.shisen");
  const frames = framesOf(folder).map((name) => read(folder, name));
  const up = (size, step) => Math.ceil(size / step) * step;
  const head = Uint32Array.from([scene.length, frames.length, ...frames.map(({ length }) => length)]);
  const parts = [[0, new Uint8Array(head.buffer)], [up(head.byteLength, 64), scene]];
  let at = up(head.byteLength, 64) + up(scene.length, 4);
  for (const frame of frames) {
    parts.push([at, frame]);
    at += frame.length;
  }
  const memory = new Uint8Array(at);
  parts.forEach(([start, bytes]) => memory.set(bytes, start));
  return memory;
}

/// What a browser runs: the same as node.
const inBrowser = (program, names) => `(async () => {
  const bytes = async (url) => new Uint8Array(await (await fetch(url)).arrayBuffer());
  const { hashes } = await import("/same/hashes.js");
  const frames = await Promise.all(${JSON.stringify(names)}.map((name) => bytes("/case/" + name)));
  return hashes(await import("/frame.js"), await bytes("/${program}.wasm"), await bytes("/case/scene.shisen"), frames);
})()`;

/// How many frames have these lines' hashes.
function equal(recorded, lines) {
  const has = new Set(lines);
  return recorded.filter((hashes, number) => hashes.every((hash) => has.has(`${number} ${hash}`))).length;
}

async function compare(page, work) {
  const frame = await import(path.join(page, "frame.js"));
  let folder = null;
  // The page, and besides it what is compared.
  const server = await serve((first, ...rest) => {
    const root = { case: folder, same: here }[first];
    return root ? path.join(root, ...rest) : path.join(page, first, ...rest);
  });
  const browser = await openBrowser();
  await browser.send("Page.navigate", { url: `${server.url}/frame.js` });
  while (!(await browser.value("location.protocol === 'http:'"))) await new Promise((done) => setTimeout(done, 20));
  const found = [];
  const folders = fs.readdirSync(work).filter((name) => fs.existsSync(path.join(work, name, "scene.shisen")));
  for (const own of folders) {
    folder = path.join(work, own);
    const scene = read(folder, "scene.shisen");
    const names = framesOf(folder);
    const frames = names.map((name) => read(folder, name));
    const recorded = names.map((name) =>
      fs.readFileSync(path.join(folder, name.replace(".frame", ".hashes")), "utf8").trim().split("\n"));
    const counts = {};
    for (const [device, name] of Object.entries(PATHS)) {
      counts[name] = JSON.parse(fs.readFileSync(path.join(work, `${device}-${own}`), "utf8")).verified.equal;
    }
    for (const [program, name] of Object.entries(PROGRAMS)) {
      const traced = await hashes(frame, read(page, `${program}.wasm`), scene, frames);
      counts[`${name}, node`] = equal(recorded, traced);
      counts[`${name}, browser`] = equal(recorded, await browser.value(inBrowser(program, names)));
    }
    const device = path.join(folder, "device");
    if (fs.existsSync(device)) counts["Cortex-M7"] = equal(recorded, fs.readFileSync(device, "utf8").split("\n"));
    const held = frames.map(described);
    found.push({
      scene: own.slice(0, own.lastIndexOf("-")), frames: recorded.length, equal: counts,
      effects: held.reduce((all, { effects }) => all | effects, 0),
      cut: held.filter(({ cuts }) => cuts > 0).length,
      moved: held.filter(({ moved }) => moved > 0).length,
    });
  }
  browser.close();
  server.close();
  return found;
}

/// Prints the table; returns whether all is equal, and all is there that is to be compared.
function print(found, most) {
  const columns = [...new Set(found.flatMap(({ equal }) => Object.keys(equal)))];
  console.log(`| Scene | ${columns.join(" | ")} |\n|---|${"---:|".repeat(columns.length)}`);
  for (const scene of new Set(found.map(({ scene }) => scene))) {
    const cells = columns.map((column) => {
      const own = found.filter((one) => one.scene === scene && column in one.equal);
      const sum = (of) => own.reduce((sum, one) => sum + of(one), 0);
      return own.length > 0 ? `${sum(({ equal }) => equal[column])} of ${sum(({ frames }) => frames)}` : "–";
    });
    console.log(`| ${scene} | ${cells.join(" | ")} |`);
  }
  const bits = found.reduce((all, { effects }) => all | effects, 0);
  const effects = [...Array(32).keys()].filter((bit) => bits & (1 << bit)).length;
  const [cut, moved] = ["cut", "moved"].map((what) => found.reduce((sum, one) => sum + one[what], 0));
  console.log(`${effects} of ${most} effects, ${cut} frames that a budget cut off, ${moved} frames with moved objects`);
  const isEqual = found.every(({ frames, equal }) => Object.values(equal).every((count) => count === frames));
  return isEqual && effects >= most && cut > 0 && moved > 0;
}

const [, , first, second, effects] = process.argv;
if (first === "--pack") {
  fs.writeFileSync(1, pack(second));
} else {
  process.exit(print(await compare(path.resolve(first), second), Number(effects)) ? 0 : 1);
}
