// The page: the walls, the gaze, and workers that render tiles.
import { ACUITY, Core, TILE, byGaze, domePicture, encode, tiles, vectors, wallPicture } from "./frame.js";
import { measureFovea } from "./fovea.js";
import { playable, readRecord, seen, writeRecord } from "./record.js";
import { angles, directionAt, eyeOf, placeOf, placeWalls, wallsOf } from "./stage.js";

const { plus } = vectors;
const $ = (id) => document.getElementById(id);

// --- what is chosen ----------------------------------------------------------

const state = {
  scene: null,
  detail: "foveated",
  view: "net",
  size: 256,
  levels: false,
  frozen: false,
  steps: 0,
  forward: [0, 0, -1],
};

/// Makes radio buttons.
function choices(id, names, chosen, choose) {
  for (const name of names) {
    const label = document.createElement("label");
    const button = Object.assign(document.createElement("input"), {
      type: "radio", name: id, value: name, checked: name === chosen,
    });
    button.addEventListener("change", () => choose(name));
    label.append(button, ` ${name}`);
    $(id).append(label);
  }
}

const choose = (id, value) => {
  const button = document.querySelector(`#${id} input[value="${value}"]`);
  if (button && !button.checked) button.click();
};

/// Shows what is chosen already.
function mark(id, value) {
  document.querySelectorAll(`#${id} input`).forEach((button) => { button.checked = button.value === value; });
}

// --- pictures ------------------------------------------------------------------

let pictures = [];
let canvases = [];

function layOut() {
  const { size } = state;
  const isDome = state.scene?.dome;
  pictures = isDome ? [domePicture(size)]
    : wallsOf(state).map((wall) => inScene(wallPicture(wall, eyeOf(state), [size, size])));
  if (canvases.length !== pictures.length || canvases[0].width !== size) {
    canvases = pictures.map(() => Object.assign(document.createElement("canvas"), { width: size, height: size }));
    $("room").replaceChildren(...canvases);
    full = 0;
    thaw();
  }
  place();
}

/// Ends the freeze of a picture that is not there any more.
function thaw() {
  if (state.frozen) $("frozen").click();
}

/// The rays of a picture where a record's viewer has flown.
function inScene(picture) {
  if (!state.flown) return picture;
  const [from, ...others] = picture.vectors.map(state.flown);
  return { ...picture, vectors: [plus(from, state.origin), ...others] };
}

const width = () => $("stage").getBoundingClientRect().width;
const place = () => placeWalls(state, $("room"), canvases, width());

function showMark() {
  const at = placeOf(state, width(), state.forward);
  $("mark").hidden = !at;
  if (at) Object.assign($("mark").style, { left: `${at[0]}px`, top: `${at[1]}px` });
}

// --- workers ---------------------------------------------------------------------

const COUNT = Math.max(1, Math.min(8, navigator.hardwareConcurrency || 2));
let workers = [];
let module = null;
let own = null;
let opened = 0;
/// The newest scene that was chosen.
let opening = null;

const SIMD = new Uint8Array([0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0,
  65, 0, 253, 15, 253, 98, 11]);

async function load(path) {
  const response = await fetch(path);
  if (!response.ok) throw new Error(`${path} is not there (${response.status}): run host/web/build again`);
  return response.arrayBuffer();
}

/// Opens a scene on all workers.
async function open(scene) {
  const turn = (opened += 1);
  opening = scene;
  say(`loading ${scene.name}`);
  const file = state.detail === "paper" ? scene.paper ?? scene.file : scene.file;
  const bytes = await load(file);
  workers.forEach((worker) => worker.terminate());
  workers = [];
  const core = await Core.open(module, new Uint8Array(bytes));
  const started = await Promise.all(Array.from({ length: COUNT }, async (_, number) => {
    const worker = new Worker("worker.js", { type: "module" });
    worker.postMessage({ open: { number, module, scene: bytes } });
    await new Promise((resolve, reject) => {
      worker.onmessage = ({ data }) => (data.failed ? reject(new Error(data.failed)) : resolve());
      worker.onerror = () => reject(new Error("workers do not start here: open the page over http"));
    });
    worker.onmessage = arrive;
    return worker;
  }));
  // Another scene was chosen meanwhile.
  if (turn !== opened) return started.forEach((worker) => worker.terminate());
  [workers, own] = [started, core];
  scene.desk = file;
  scene.hash = hashText(bytes);
  state.scene = scene;
  $("command").textContent = "";
  // Frames that the workers before were rendering do not come.
  flights.clear();
  full = 0;
  layOut();
  say("");
  renew();
}

// --- frames ----------------------------------------------------------------------

/// Frames that workers are at, by their numbers: two at most, so that none waits for the slowest.
const flights = new Map();

let stale = true;
let isHashed = false;
let turned = 0;
let number = 0;
let full = 0;
let newest = null;
let arrived = 0;

function frame() {
  const { forward, detail } = state;
  const up = state.up ?? (Math.abs(forward[1]) > 0.99 ? [0, 0, -1] : [0, 1, 0]);
  return {
    detail,
    samples: detail === "foveated" ? 4 : 1,
    acuity: state.acuity ?? ACUITY,
    pictures,
    recorded: isAsRecorded() ? played.frames[Number($("moment").value)] : null,
    ...state.left,
    gaze: state.flown
      ? { place: plus(state.flown(eyeOf(state)), state.origin), forward: state.flown(forward), up: state.flown(up) }
      : { place: eyeOf(state), forward, up },
  };
}

/// Pixels a side of the tiles of frames that are only looked at.
const SIDE = 64;

/// Renders a frame on all workers; returns what it took, with hashes where it is checked.
function render(frame, isChecked) {
  number += 1;
  const bytes = encode(frame);
  const order = byGaze(frame.pictures, frame.gaze.forward, isChecked || frame.cuts?.length > 0 ? TILE : SIDE);
  const steps = Math.ceil(state.steps / workers.length);
  workers.forEach((worker, rank) => {
    const own = order.filter((_, at) => at % workers.length === rank);
    worker.postMessage({ number, frame: bytes.buffer, tiles: own, steps, isChecked });
  });
  const took = { steps: 0, rays: 0, unfinished: 0, hashes: new Map() };
  return new Promise((resolve, reject) => {
    flights.set(number, { took, canvases, parts: [], begun: performance.now(), resolve, reject });
  });
}

/// Takes a worker's part of a frame, and shows the frame when all are there.
function arrive({ data }) {
  const flight = flights.get(data.number);
  if (!flight) return;
  const { took, parts } = flight;
  parts.push(data);
  if (data.failed) {
    flights.delete(data.number);
    flight.reject(new Error(data.failed));
  } else if (parts.length === workers.length) {
    flights.delete(data.number);
    for (const part of parts) {
      if (flight.canvases === canvases) show(part);
      took.steps += part.steps;
      took.rays += part.rays;
      took.unfinished += part.unfinished;
      part.hashes.forEach((hash, at) => took.hashes.set(String(part.tiles[at]), hash));
    }
    const now = performance.now();
    took.seconds = (now - Math.max(flight.begun, arrived)) / 1000;
    arrived = now;
    flight.resolve(took);
  }
  begin();
}

function show({ tiles, pixels }) {
  let at = 0;
  for (const [picture, x, y, width, height] of tiles) {
    const own = pixels.subarray(at, (at += 4 * width * height));
    canvases[picture]?.getContext("2d").putImageData(new ImageData(own, width, height), x, y);
  }
}

/// Milliseconds of rest before what is shown is hashed.
const REST = 300;

/// Begins a frame where there is one to begin and a worker to begin it.
function begin() {
  const now = performance.now();
  const isFree = flights.size < 2 && [...flights.values()].every(({ parts }) => parts.length > 0);
  const isComparable = played ? isAsRecorded() : !state.screen && !state.scene?.dome;
  const rests = !stale && !isHashed && flights.size === 0 && now - turned > REST && !state.steps && isComparable;
  if (isFree && (stale || rests) && !state.frozen && state.scene && workers.length) {
    if (stale) turned = now;
    stale = false;
    isHashed = rests;
    renderChosen(rests);
  }
}

/// Has what is chosen rendered again.
function renew() {
  stale = true;
  begin();
}

/// Renders what is chosen, and shows and hashes it.
async function renderChosen(isChecked) {
  const shown = frame();
  const { scene, size } = state;
  try {
    const took = await render(shown, isChecked);
    newest = { ...took, frame: shown, scene, size };
    showMark();
    if (isChecked) showHash(newest);
    else report(newest);
    if (state.levels) drawLevels(shown);
    if (!isHashed) setTimeout(begin, REST + 1);
  } catch (error) {
    say(String(error.message));
  }
}

/// Draws how much detail each part has.
function drawLevels(shown) {
  own.begin(encode(shown));
  pictures.forEach(({ size: [columns, rows] }, picture) => {
    const context = canvases[picture].getContext("2d");
    for (let y = 0; y < rows; y += 16) {
      for (let x = 0; x < columns; x += 16) {
        const detail = own.exports.detail(picture, x + 8, y + 8);
        const part = shown.detail === "foveated" ? 1 / detail : detail;
        if (part < 1) {
          context.fillStyle = `hsl(${Math.round(240 * (1 - part))} 90% 50% / 45%)`;
          context.fillRect(x, y, 16, 16);
        }
      }
    }
  });
}

// --- numbers -----------------------------------------------------------------------

const charts = { rate: [], rays: [], steps: [] };
const few = (number) => number >= 1e6 ? `${(number / 1e6).toFixed(2)} M` : `${(number / 1e3).toFixed(0)} k`;

/// Milliseconds between two looks at the numbers.
const GLANCE = 200;
let glance = 0;

function report(took) {
  if (took.frame.detail === "full" && !state.steps) full = took.steps;
  $("hash").textContent = state.steps ? "– (not within a budget: slide it to its end)"
    : state.screen || state.scene.dome ? "– (not of this picture: three walls have one)" : "–";
  $("compared").textContent = $("command").textContent = "";
  $("save").disabled = true;
  document.body.dataset.frames = number;
  glance ||= setTimeout(showNumbers, GLANCE);
}

function showNumbers() {
  glance = 0;
  const took = newest;
  const rate = 1 / took.seconds;
  $("rate").textContent = rate.toFixed(1);
  $("rays").textContent = few(took.rays);
  $("steps").textContent = few(took.steps);
  $("part").textContent = full ? `${Math.round(100 * took.steps / full)} %` : "–";
  for (const [name, value] of [["rate", rate], ["rays", took.rays], ["steps", took.steps]]) {
    const values = charts[name];
    values.push(value);
    if (values.length > 60) values.shift();
    chart($(`${name}-chart`), values);
  }
}

/// Shows the hashes of a frame's walls, which a record of it has.
function showHash(took) {
  const hashes = hashesOf(took);
  $("hash").textContent = hashes.map(({ hash }) => text(hash)).join(" ");
  const { recorded } = took.frame;
  $("save").disabled = Boolean(recorded);
  if (!recorded) {
    const { desk, name } = took.scene;
    $("command").textContent = `curl -O ${new URL(desk, location)}\nshisen replay ${name}.rec --verify`;
    return;
  }
  const isSame = hashes.every(({ hash }, wall) => hash === recorded.hashes[wall]);
  $("compared").textContent = isSame ? "the same as recorded, bit for bit" : "not the bits that were recorded";
}

const text = (hash) => hash.toString(16).padStart(16, "0");
const hashText = (bytes) => text(own.hashOf(new Uint8Array(bytes)));

function hashesOf(took) {
  const all = tiles(took.frame.pictures).map((tile) => took.hashes.get(String(tile)));
  return own.wallHashes(took.frame.pictures, all);
}

function chart(canvas, values) {
  const context = canvas.getContext("2d");
  const most = Math.max(...values, 1e-9);
  context.clearRect(0, 0, canvas.width, canvas.height);
  context.strokeStyle = getComputedStyle(document.body).color;
  context.beginPath();
  values.forEach((value, at) => context.lineTo(1.5 * at, canvas.height - 1 - (canvas.height - 2) * value / most));
  context.stroke();
}

function say(text) {
  $("message").textContent = text;
}

// --- input ---------------------------------------------------------------------------

function look(forward) {
  if (!forward) return;
  state.forward = forward.map(Math.fround);
  if (state.frozen) showMark();
  renew();
}

function turn(right, up) {
  if (played) return;
  const [yaw, pitch] = angles(state.forward);
  const [a, b] = [yaw + right, Math.max(-1.5, Math.min(1.5, pitch + up))];
  look([Math.sin(a) * Math.cos(b), Math.sin(b), -Math.cos(a) * Math.cos(b)]);
}

const STEP = 2 * Math.PI / 180;
const KEYS = {
  ArrowLeft: () => turn(-STEP, 0),
  ArrowRight: () => turn(STEP, 0),
  ArrowUp: () => turn(0, STEP),
  ArrowDown: () => turn(0, -STEP),
  " ": () => $("frozen").click(),
  l: () => $("levels").click(),
  v: () => choose("views", state.view === "net" ? "viewer" : "net"),
  f: () => choose("details", "full"),
  p: () => choose("details", "paper"),
  o: () => choose("details", "foveated"),
  "[": () => budget(-1),
  "]": () => budget(1),
};

function budget(by) {
  $("budget").value = Number($("budget").value) + by;
  $("budget").dispatchEvent(new Event("input"));
}

function listen() {
  const stage = $("stage");
  const follow = (event) => {
    if (played) return;
    const { left, top } = stage.getBoundingClientRect();
    look(directionAt(state, width(), [event.clientX - left, event.clientY - top]));
  };
  stage.addEventListener("pointermove", follow);
  stage.addEventListener("pointerdown", follow);
  addEventListener("keydown", (event) => {
    // A button, a slider and a list of choices have keys of their own.
    const hasKeys = event.target.closest("button, summary, input, dialog");
    const act = KEYS[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    const digit = Number(event.key);
    if ($("fovea").open) return;
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (digit >= 1 && digit <= scenes.length) choose("scenes", scenes[digit - 1].name);
    else if (!act || (hasKeys && (event.key === " " || event.key.startsWith("Arrow")))) return;
    else act();
    event.preventDefault();
  });
  addEventListener("resize", () => {
    if (state.screen) {
      screenOfEye();
      again();
    } else {
      place();
      showMark();
    }
  });
  $("levels").addEventListener("change", ({ target }) => { state.levels = target.checked; renew(); });
  $("frozen").addEventListener("change", ({ target }) => {
    state.frozen = target.checked;
    $("play").textContent = "Play";
    begin();
  });
  $("budget").addEventListener("input", ({ target }) => {
    const part = Number(target.value);
    state.steps = part >= 40 ? 0 : Math.round(10 ** (3 + part / 10));
    $("budget-text").textContent = state.steps ? `${few(state.steps)} steps a frame` : "no end";
    renew();
  });
  $("budget").dispatchEvent(new Event("input"));
  $("record").addEventListener("change", ({ target }) => target.files[0] && openRecord(target.files[0]));
  addEventListener("dragover", (event) => event.preventDefault());
  addEventListener("drop", (event) => {
    event.preventDefault();
    if (event.dataTransfer.files[0]) openRecord(event.dataTransfer.files[0]);
  });
  $("moment").addEventListener("input", () => {
    began();
    showMoment();
  });
  $("play").addEventListener("click", play);
  $("save").addEventListener("click", save);
  $("measure").addEventListener("click", measure);
  $("usual").addEventListener("click", usual);
  $("leave").addEventListener("click", () => {
    leave();
    again();
  });
  $("numbers-save").addEventListener("click", () => download("eye.json", JSON.stringify(state.eye, null, 1)));
}

/// Renders for the visitor's own eye: the picture is a window of its size at its distance.
async function measure() {
  const found = await measureFovea($("fovea"));
  if (!found) return;
  if (!found.seen) return say("the screen is too narrow at this distance: sit nearer to it, 15 to 200 cm, and try again");
  usual();
  const { slope, least } = found;
  state.acuity = [slope, least, 0, 1, 0];
  state.eye = found;
  screenOfEye();
  const minutes = (angle) => (60 * angle * 180 / Math.PI).toFixed(1);
  $("eye").textContent = `You see ${minutes(least)}′ where you look, and ${(60 * slope).toFixed(1)}′ more for each `
    + "degree beside it. Look at the pointer: the picture is rendered for that.";
  $("numbers-save").disabled = $("usual").disabled = false;
  choose("details", "foveated");
  again();
}

/// The window as large as the stage is on the visitor's screen, at their distance.
function screenOfEye() {
  const { pixelsAMetre, distance } = state.eye;
  const half = width() / pixelsAMetre / 2;
  state.screen = {
    name: "screen", lowerLeft: [-half, -half, -distance], lowerRight: [half, -half, -distance],
    upperLeft: [-half, half, -distance],
  };
}

/// Goes back to the usual eye and its room.
function usual() {
  leave();
  state.screen = state.acuity = state.eye = undefined;
  $("eye").textContent = "";
  $("numbers-save").disabled = $("usual").disabled = true;
  again();
}

/// Leaves the record that is played.
function leave() {
  thaw();
  played = null;
  state.head = state.flown = state.up = state.left = undefined;
  $("play").disabled = $("moment").disabled = $("leave").disabled = true;
  $("play").textContent = "Play";
  $("moment-text").textContent = $("compared").textContent = "";
  say("");
}

function again() {
  layOut();
  showMark();
  renew();
}

function download(name, bytes) {
  const href = URL.createObjectURL(new Blob([bytes]));
  Object.assign(document.createElement("a"), { href, download: name }).click();
}

/// Saves the newest frame as a record that a desk replays.
function save() {
  if (!newest) return;
  download(`${newest.scene.name}.rec`, writeRecord(own, newest, hashesOf(newest)));
}

// --- records -------------------------------------------------------------------------

/// The record that is played: its frames, and what is not shown of them.
let played = null;

async function openRecord(file) {
  try {
    const { sessions, isWhole, damaged } = readRecord(own, new Uint8Array(await file.arrayBuffer()));
    if (sessions.length === 0) {
      throw new Error(damaged.length > 0 ? "the record's session is not what was recorded: record it again"
        : "the record has no frames");
    }
    const { setup, frames } = sessions[0];
    const way = playable(setup, frames);
    const scene = (await sceneOf(setup.scene_hash)) ?? (way.hasMesh ? undefined : sceneNamed(setup.scene));
    if (!scene) throw new Error(`the record's scene ${way.scene} is not on this page: shisen web --scene serves it, shisen replay shows it`);
    usual();
    const isOther = opening !== scene || (scene.paper && (way.detail === "paper") !== (state.detail === "paper"));
    state.detail = way.detail;
    mark("details", way.detail);
    mark("scenes", scene.name);
    if (isOther) await open(scene);
    const notes = [...way.notes];
    if (scene.hash !== setup.scene_hash) notes.unshift("the scene was baked otherwise: alike, not the same bits");
    if (way.side > 0) state.size = way.side;
    mark("sizes", String(state.size));
    const isSame = notes.length === 0;
    if (sessions.length > 1) notes.push("the first session alone");
    if (damaged.length > 0) notes.push(`not what was recorded: frame ${damaged.join(", ")}`);
    else if (!isWhole) notes.push("the record was cut off");
    played = { ...way, setup, frames, notes, isSame };
    say("");
    Object.assign($("moment"), { max: frames.length - 1, value: 0, disabled: false });
    $("play").disabled = $("leave").disabled = false;
    $("player").open = true;
    showMoment();
  } catch (error) {
    say(error.constructor === Error ? error.message : `the record cannot be read: ${error.message}`);
  }
}

/// The scene of the page that has a hash; undefined without.
async function sceneOf(hash) {
  for (const scene of scenes) {
    for (const file of [scene.file, scene.paper].filter(Boolean)) {
      if (hashText(await load(file)) === hash) return scene;
    }
  }
}

/// The scene of the page that has a desk's name for it.
function sceneNamed(desk) {
  const wanted = desk.split(/[\\/]/).at(-1);
  return scenes.find(({ file, paper, name, source }) => [file, paper, name, source].includes(wanted)
    || (wanted === "A" && name === "animal"));
}

/// Whether a record is played as the desk rendered it, to the bit.
const isAsRecorded = () => played?.isSame && state.size === played.side && state.detail === played.detail;

/// Shows the frame of the time line.
function showMoment() {
  const { setup, frames, notes, side } = played;
  const isItsDetail = state.detail === played.detail;
  thaw();
  const frame = frames[Number($("moment").value)];
  const { eye, turned, origin, up, left } = seen(frame, setup);
  Object.assign(state, { head: eye, flown: turned, origin, up, left });
  if (isItsDetail) Object.assign(left, played.exact);
  if (!isItsDetail || state.size !== side) left.cuts = [];
  $("moment-text").textContent = [`${frame.at.toFixed(2)} s`, ...notes].join("; ");
  layOut();
  look(frame.forward);
}

/// When the record would have begun to play to be where it is.
let beginning = 0;
function began() {
  beginning = performance.now() - 1000 * played.frames[Number($("moment").value)].at;
}

/// Plays the record in its own time, again from the start where it has ended.
function play() {
  thaw();
  if ($("moment").value === $("moment").max) $("moment").value = 0;
  began();
  const step = () => {
    if ($("play").textContent !== "Pause") return;
    const now = (performance.now() - beginning) / 1000;
    const next = played.frames.findLastIndex(({ at }) => at <= now);
    $("moment").value = Math.max(0, next);
    showMoment();
    if (next + 1 < played.frames.length) setTimeout(step, 30);
    else $("play").textContent = "Play";
  };
  $("play").textContent = $("play").textContent === "Play" ? "Pause" : "Play";
  step();
}

// --- start -----------------------------------------------------------------------------

let scenes = [];

async function start() {
  if (!globalThis.Worker || !globalThis.WebAssembly) {
    throw new Error("this browser has no workers or no WebAssembly, and the page traces with both: take another one");
  }
  scenes = JSON.parse(new TextDecoder().decode(await load("scenes.json")));
  const hasSimd = WebAssembly.validate(SIMD);
  const notes = [`${COUNT} workers`];
  if (!hasSimd) notes.push("this browser has no vectors (simd128): slower, the same bits");
  module = await WebAssembly.compile(await load(hasSimd ? "shisen-simd.wasm" : "shisen.wasm"));
  $("notes").textContent = notes.join("; ");
  const wanted = new URLSearchParams(location.hash.slice(1));
  $("last-scene").textContent = scenes.length;
  const first = scenes.find(({ name }) => name === wanted.get("scene")) ?? scenes[0];
  const [sizes, details] = [["128", "256", "512"], ["full", "paper", "foveated"]];
  state.size = Number(sizes.find((size) => size === wanted.get("size")) ?? (innerWidth < 800 ? 128 : 256));
  state.detail = details.find((detail) => detail === wanted.get("detail")) ?? state.detail;
  choices("scenes", scenes.map(({ name }) => name), first.name, (name) => {
    leave();
    open(scenes.find((scene) => scene.name === name)).catch((error) => say(error.message));
  });
  choices("details", details, state.detail, (detail) => {
    const needsLevels = opening.paper && (detail === "paper") !== (state.detail === "paper");
    state.detail = detail;
    if (played) showMoment();
    else renew();
    if (needsLevels) open(opening).catch((error) => say(error.message));
  });
  choices("views", ["net", "viewer"], state.view, (view) => { state.view = view; place(); showMark(); });
  choices("sizes", sizes, String(state.size), (size) => {
    state.size = Number(size);
    if (played) showMoment();
    else again();
  });
  listen();
  await open(first);
  showMark();
}

start().catch((error) => say(String(error.message)));
