// Renders the described frames of folders, and prints how many are what a record has.
//
//   node same.mjs PAGE FOLDER...   in node and in a browser, by the programs of the page in PAGE; a
//                                  folder is one of `shisen replay --describe`, with what a
//                                  microcontroller printed in a file device
//   node same.mjs --pack FOLDER    prints the memory of a microcontroller, as
//                                  tests/firmware/src/bin/replay.rs reads it
import fs from "node:fs";
import http from "node:http";
import path from "node:path";
import { openBrowser } from "../web/browser.mjs";
import { described, hashes } from "./hashes.js";

const PROGRAMS = { shisen: "wasm", "shisen-simd": "wasm simd128" };
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

/// Serves the page, and a folder's files under /case/.
function serve(page, folder) {
  const types = { ".js": "text/javascript", ".html": "text/html" };
  const server = http.createServer(({ url }, answer) => {
    const [, first, ...rest] = url.split("/");
    const root = { case: folder(), same: here }[first];
    const file = root ? path.join(root, ...rest) : path.join(page, first, ...rest);
    if (!fs.existsSync(file)) return answer.writeHead(404).end();
    answer.writeHead(200, { "content-type": types[path.extname(file)] ?? "application/octet-stream" });
    answer.end(fs.readFileSync(file));
  });
  return new Promise((done) => server.listen(0, "127.0.0.1", () => done(server)));
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

async function compare(page, folders) {
  const frame = await import(path.join(page, "frame.js"));
  let folder = null;
  const server = await serve(page, () => folder);
  const browser = await openBrowser();
  await browser.send("Page.navigate", { url: `http://127.0.0.1:${server.address().port}/frame.js` });
  while (!(await browser.value("location.protocol === 'http:'"))) await new Promise((done) => setTimeout(done, 20));
  const found = [];
  for (folder of folders) {
    const scene = read(folder, "scene.shisen");
    const names = framesOf(folder);
    const frames = names.map((name) => read(folder, name));
    const recorded = names.map((name) =>
      fs.readFileSync(path.join(folder, name.replace(".frame", ".hashes")), "utf8").trim().split("\n"));
    const counts = {};
    for (const [program, name] of Object.entries(PROGRAMS)) {
      const own = await hashes(frame, read(page, `${program}.wasm`), scene, frames);
      counts[`${name}, node`] = equal(recorded, own);
      counts[`${name}, browser`] = equal(recorded, await browser.value(inBrowser(program, names)));
    }
    const device = path.join(folder, "device");
    if (fs.existsSync(device)) counts["Cortex-M7"] = equal(recorded, fs.readFileSync(device, "utf8").split("\n"));
    const held = frames.map(described);
    found.push({
      folder: path.basename(folder), frames: recorded.length, equal: counts,
      effects: held.reduce((all, { effects }) => all | effects, 0),
      cut: held.filter(({ cuts }) => cuts > 0).length,
      moved: held.filter(({ moved }) => moved > 0).length,
    });
  }
  browser.close();
  server.close();
  return found;
}

const [, , first, ...folders] = process.argv;
if (first === "--pack") {
  fs.writeFileSync(1, pack(folders[0]));
} else {
  console.log(JSON.stringify(await compare(path.resolve(first), folders), null, 1));
  process.exit(0);
}
