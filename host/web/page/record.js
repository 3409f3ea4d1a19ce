// Records of frames: see host/doc/record.md.
import { TILE, lowered, tiles } from "./frame.js";

const text = new TextEncoder();
/// The options of `shisen run` that the page does not follow.
const OTHERS = ["--fixate", "--up", "--animation", "--depth", "--effects", "--quality", "--acuity", "--dispersion",
  "--wavelengths", "--each", "--range"];
const LARGEST = 16384; // Pixels along a side of a wall.

/// A record of one frame, which `shisen replay` renders on a desk.
export function writeRecord(core, { frame, scene, size }, walls) {
  const entry = (kind, content) => {
    const bytes = new Uint8Array(5 + content.length + 4);
    const view = new DataView(bytes.buffer);
    bytes[0] = kind;
    view.setUint32(1, content.length, true);
    bytes.set(content, 5);
    const check = core.hashOf(bytes.slice(0, 5 + content.length));
    view.setUint32(5 + content.length, Number(BigInt.asUintN(32, check)), true);
    return bytes;
  };
  const lod = { full: "off", paper: "paper", foveated: "foveated" }[frame.detail];
  const setup = {
    program: "a page",
    arguments: ["run", "--scene", scene.desk, "--layout", "compact", "--size", String(size), "--eyes", "1", "--lod", lod],
    folder: "",
    changes: [],
    fill: "background",
    scene: scene.desk,
    scene_hash: scene.hash,
    walls: null,
    tile: 32,
    pictures: ["front", "right", "floor"].map((name) => ({ name, eye: "centre", size: [size, size] })),
    rungs: [{ depth: 16, faces: 1, field: 1, centre: 1, sampling: 1, capture: 1 }],
  };
  const content = [];
  const number = (whole) => content.push(whole);
  const doubles = (numbers) => content.push(...new Uint8Array(new Float64Array(numbers).buffer));
  const floats = (numbers) => content.push(...new Uint8Array(new Float32Array(numbers).buffer));
  [0, 0, 0, 0].forEach(number);
  doubles([0]);
  floats([0, 0, 0, 0, 0, 0, 1, ...frame.gaze.forward, ...frame.gaze.up]);
  number(0);
  for (const { hash } of walls) content.push(...new Uint8Array(new BigUint64Array([hash]).buffer));
  for (const { rows } of walls) content.push(...new Uint8Array(new Uint32Array(rows).buffer));
  return new Blob([
    text.encode("shisen record 1\n"),
    entry(1, text.encode(JSON.stringify(setup))),
    entry(2, Uint8Array.from(content)),
    entry(4, new Uint8Array()),
  ]);
}

/// The frames of a record, as far as it can be read: {sessions: [{setup, frames: [{number, at, time,
/// place, head, turn, forward, up, rung, cuts, hashes}]}], isWhole, damaged}, the latter frames by number.
/// `core` computes hashes.
export function readRecord(core, bytes) {
  const first = new TextDecoder().decode(bytes.slice(0, 16));
  if (first !== "shisen record 1\n") {
    const [, version] = /^shisen record (\S+)/.exec(first) ?? [];
    throw new Error(version ? `a record of version ${version}, and this page reads version 1` : "this file is no record");
  }
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const [sessions, damaged] = [[], []];
  let [at, next] = [16, 0];
  let isWhole = false;
  while (at + 9 <= bytes.length && !isWhole) {
    const [kind, length] = [bytes[at], view.getUint32(at + 1, true)];
    const end = at + 5 + length;
    if (end + 4 > bytes.length) break;
    const check = BigInt.asUintN(32, core.hashOf(bytes.slice(at, end)));
    at = end + 4;
    if (Number(check) !== view.getUint32(end, true)) {
      damaged.push(next);
      next += kind === 2;
      // Another kind or length would lead nowhere.
      if (kind === 2 || kind === 3) continue;
      break;
    }
    const content = bytes.slice(end - length, end);
    if (kind === 1) {
      const setup = JSON.parse(new TextDecoder().decode(content));
      const fits = ({ size }) => size.every((side) => side >= 1 && side <= LARGEST);
      if (!setup.pictures.every(fits)) throw new RangeError("a picture has no size");
      sessions.push({ setup, frames: [] });
    }
    if (kind === 2 && sessions.length > 0) {
      const frame = readFrame(content, sessions.at(-1).setup);
      sessions.at(-1).frames.push(frame);
      next = frame.number + 1;
    }
    isWhole = kind === 4;
  }
  return { sessions: sessions.filter(({ frames }) => frames.length > 0), isWhole, damaged };
}

function readFrame(bytes, setup) {
  const view = new DataView(bytes.buffer);
  let at = 0;
  const byte = () => {
    if (at >= bytes.length) throw new RangeError("a frame ends too early");
    return bytes[at++];
  };
  const number = () => {
    let [value, factor] = [0, 1];
    for (;;) {
      const next = byte();
      value += (next & 127) * factor;
      if (next < 128) return value;
      factor *= 128;
    }
  };
  const floats = (count) => Array.from({ length: count }, () => { at += 4; return view.getFloat32(at - 4, true); });
  const doubles = (count) => Array.from({ length: count }, () => { at += 8; return view.getFloat64(at - 8, true); });
  const flags = byte();
  const frame = { number: number(), at: number() / 1e6, rung: number(), steps: flags & 1 ? number() : 0 };
  [frame.time] = doubles(1);
  frame.place = flags & 4 ? doubles(4) : [0, 0, 0, 0];
  [frame.head, frame.turn, frame.forward, frame.up] = [floats(3), floats(4), floats(3), floats(3)];
  frame.widen = flags & 8 ? floats(1)[0] : 0;
  let tile = 0;
  frame.cuts = Array.from({ length: number() }, () => [tile += number(), number()]);
  frame.hashes = setup.pictures.map(() => { at += 8; return view.getBigUint64(at - 8, true); });
  return frame;
}

/// How the page plays a session: {scene, its name and the file of its mesh; hasMesh; detail; exact, of a
/// frame in that detail; side, of its pictures, 0 where they are not squares; notes, on what is otherwise}.
export function playable(setup, frames) {
  const words = setup.arguments.flatMap((word) => {
    const [, option, value] = /^(--[a-z-]+)=(.*)$/.exec(word) ?? [];
    return option ? [option, value] : [word];
  });
  const option = (name, usual) => (words.includes(name) ? words[words.indexOf(name) + 1] : usual);
  if (setup.walls || option("--walls", "three-wall") !== "three-wall") {
    throw new Error("the record is of other walls than these three: shisen replay shows it");
  }
  const lod = option("--lod", /^[A-D]$/.test(setup.scene) ? "paper" : "foveated");
  const samples = Number(option("--samples", lod === "foveated" ? 4 : 1));
  const exact = {
    samples: lod === "foveated" ? 4 * Math.ceil(samples / 4) : samples,
    ...(lod === "paper-ellipse" ? { detail: "ellipse" } : {}),
  };
  const notes = [];
  if (option("--eyes", "2") === "2") notes.push("for one eye in the middle");
  if (setup.fill !== "background") notes.push("without what earlier frames left where the gaze skips rays");
  const unfollowed = OTHERS.filter((name) => words.includes(name));
  if (unfollowed.length > 0) notes.push(`without ${unfollowed.join(", ")}: shisen replay has it`);
  if (frames.some(({ place }) => place.some((number) => number !== 0))) {
    notes.push("where the viewer flew alike, not the same bits");
  }
  const [side] = setup.pictures[0].size;
  const isSquare = setup.tile === TILE && setup.pictures.every(({ size }) => size[0] === side && size[1] === side);
  if (!isSquare) notes.push("in another size, and what budgets cut off is not shown");
  const detail = { off: "full", paper: "paper", "paper-ellipse": "paper" }[lod] ?? "foveated";
  const hasMesh = words.includes("--mesh");
  const scene = [setup.scene, option("--mesh")].filter(Boolean).join(" of ");
  return { scene, hasMesh, detail, exact, side: isSquare ? side : 0, notes };
}

/// What an eye in the middle of the head saw in a frame: {eye, in the room; turned, which turns what is
/// of the room into the scene; origin, of the room in the scene; forward; up; left, of the detail}.
export function seen(frame, setup) {
  const [x, y, z, yaw] = frame.place;
  const [sin, cos] = [Math.sin(yaw), Math.cos(yaw)];
  const left = lowered(setup.rungs[frame.rung]);
  left.acuity[2] = frame.widen;
  left.cuts = cutsOf(frame, setup);
  return {
    eye: frame.head,
    turned: ([a, b, c]) => [cos * a + sin * c, b, cos * c - sin * a],
    origin: [x, y, z],
    forward: frame.forward,
    up: frame.up,
    left,
  };
}

/// The tiles that a frame's budget cut off, of the first eye.
function cutsOf({ cuts }, { pictures }) {
  const eyes = new Set(pictures.map(({ eye }) => eye)).size;
  const all = tiles(pictures);
  const own = cuts.map(([number, kept]) => [all[number], kept]).filter(([[picture]]) => picture % eyes === 0);
  return own.map(([[picture, ...tile], kept]) => [picture / eyes, tile, kept]);
}
