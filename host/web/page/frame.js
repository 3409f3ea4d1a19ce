// Descriptions of frames, and the tiles of their pictures: what shisen-web reads. See src/frame.rs.

/// Pixels a side of the tiles that are hashed, as a record's.
export const TILE = 32;
// The paper's visual field: its centre, up, down, left and right.
const FIELD = [30, 60, 70, 100, 100].map((degrees) => degrees * Math.PI / 180);

// The three walls of a room of 3 m about the origin: corners as their viewer sees them, metres.
export const WALLS = [
  { name: "front", lowerLeft: [-1.5, -1.5, -1.5], lowerRight: [1.5, -1.5, -1.5], upperLeft: [-1.5, 1.5, -1.5] },
  { name: "right", lowerLeft: [1.5, -1.5, -1.5], lowerRight: [1.5, -1.5, 1.5], upperLeft: [1.5, 1.5, -1.5] },
  { name: "floor", lowerLeft: [-1.5, -1.5, 1.5], lowerRight: [1.5, -1.5, 1.5], upperLeft: [-1.5, -1.5, -1.5] },
];

const plus = (a, b) => a.map((x, axis) => x + b[axis]);
const minus = (a, b) => a.map((x, axis) => x - b[axis]);
const times = (a, factor) => a.map((x) => factor * x);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => times(a, 1 / Math.hypot(...a));
export const vectors = { plus, minus, times, dot, cross, unit };

/// The degrees around the line of sight that stay as fine as they are in all but the least qualities.
const FOVEA = 5 * Math.PI / 180;

/// What a lowered quality leaves of a frame's detail: of a record's `rungs`.
export function lowered({ depth, faces, field, centre, sampling }, acuity = ACUITY) {
  const [whole, ...limits] = FIELD;
  const central = Math.max(whole * centre, Math.min(FOVEA / 0.95, whole));
  return {
    depth: Math.min(3, depth),
    faces,
    field: [central, ...limits.map((limit) => central + (limit - whole) * field)],
    acuity: [...acuity.slice(0, 3), sampling, sampling < 6 ? FOVEA : 0],
  };
}

/// The rays from an eye through a wall's pixels, in doubles and rounded once, as the desk has them.
export function wallPicture(wall, eye, [columns, rows]) {
  const column = times(minus(wall.lowerRight, wall.lowerLeft), 1 / columns);
  const row = times(minus(wall.upperLeft, wall.lowerLeft), -1 / rows);
  const first = plus(wall.upperLeft, times(plus(column, row), 0.5));
  return { kind: 0, vectors: [eye, minus(first, eye), column, row], size: [columns, rows] };
}

/// A dome master of all directions above, its lower edge to the front.
export function domePicture(size) {
  return { kind: 1, vectors: [[0, 0, 0], [1, 0, 0], [0, 0, 1], [0, -1, 0]], size: [size, size] };
}

/// The bytes of a frame: {depth, samples, detail, acuity: [slope, least, off, factor, from],
/// pictures, gaze: {place, forward, up}, cuts: [[picture, tile, kept]]}.
export function encode(frame) {
  const words = [];
  const whole = (number) => words.push([number, true]);
  const floats = (numbers) => numbers.forEach((number) => words.push([number, false]));
  const detail = { full: 0, paper: 1, ellipse: 2, foveated: 3 }[frame.detail];
  [2, frame.depth ?? 3, frame.samples, 0xffffffff, detail].forEach(whole);
  floats([frame.faces ?? 1, ...(frame.field ?? FIELD), ...(frame.acuity ?? ACUITY)]);
  const [count, from, to, each] = frame.wavelengths ?? WAVELENGTHS;
  whole(count);
  floats([from, to]);
  whole(each);
  whole(frame.pictures.length);
  for (const picture of frame.pictures) {
    whole(picture.kind);
    picture.vectors.forEach(floats);
    picture.size.forEach(whole);
    const gaze = picture.gaze ?? frame.gaze;
    [gaze.place, gaze.forward, [0, 0, 0], gaze.up].forEach(floats);
  }
  whole(0);
  const cuts = frame.cuts ?? [];
  whole(cuts.length);
  for (const [picture, tile, kept] of cuts) [picture, ...tile, kept].forEach(whole);
  const bytes = new DataView(new ArrayBuffer(4 * words.length));
  words.forEach(([number, isWhole], at) =>
    isWhole ? bytes.setUint32(4 * at, number, true) : bytes.setFloat32(4 * at, number, true));
  return new Uint8Array(bytes.buffer);
}

/// The wavelengths of dispersion, as the desk has them: their number, from, to, and of a sample.
const WAVELENGTHS = [14, 400, 700, 1];

/// The acuity of a viewer with good eyes, by Guenter and others.
export const ACUITY = [0.0275, 0.0208 * Math.PI / 180, 0, 1, 0];

/// The tiles of pictures: [picture, x, y, width, height], row by row.
export function tiles(pictures, side = TILE) {
  const all = [];
  pictures.forEach(({ size: [columns, rows] }, picture) => {
    for (let y = 0; y < rows; y += side)
      for (let x = 0; x < columns; x += side)
        all.push([picture, x, y, Math.min(side, columns - x), Math.min(side, rows - y)]);
  });
  return all;
}

/// The tiles from the line of sight outwards.
export function byGaze(pictures, forward, side) {
  const toTile = ([picture, x, y, width, height]) => {
    const { kind, vectors: [, first, column, row] } = pictures[picture];
    if (kind !== 0) return 0;
    const [mx, my] = [x + width / 2, y + height / 2];
    return dot(unit(plus(first, plus(times(column, mx), times(row, my)))), forward);
  };
  const keyed = tiles(pictures, side).map((tile) => [toTile(tile), tile]);
  keyed.sort((a, b) => b[0] - a[0]);
  return keyed.map(([, tile]) => tile);
}

/// One instance of the program, with a scene.
export class Core {
  static async open(module, scene) {
    const instance = await WebAssembly.instantiate(module, {});
    const core = new Core((instance.exports ?? instance.instance.exports));
    core.give(scene);
    if (core.exports.open(scene.length) !== 0) {
      throw new Error("these bytes are no scene of this version, in the compact layout");
    }
    return core;
  }

  constructor(exports) {
    this.exports = exports;
  }

  give(bytes) {
    const at = this.exports.input(bytes.length);
    new Uint8Array(this.exports.memory.buffer).set(bytes, at);
  }

  begin(bytes) {
    this.give(bytes);
    if (this.exports.begin(bytes.length) !== 0) throw new Error("the frame cannot be rendered");
  }

  /// Renders a tile; returns its pixels (a view that the next call overwrites) and what it took.
  render([picture, x, y, width, height], steps = 0) {
    const { exports } = this;
    if (exports.render(picture, x, y, width, height, steps) !== 0) throw new Error("no such tile");
    return {
      pixels: new Uint8ClampedArray(exports.memory.buffer, exports.shown(), 4 * width * height),
      steps: Number(exports.steps()),
      rays: Number(exports.rays()),
      isWhole: exports.is_whole() !== 0,
    };
  }

  /// The hash of the newest tile.
  hash() {
    return BigInt.asUintN(64, this.exports.hash());
  }

  /// XXH3-64 of bytes.
  hashOf(bytes) {
    this.give(bytes);
    return BigInt.asUintN(64, this.exports.hash_of(bytes.length));
  }

  /// The hashes of pictures, by those of their tiles in the order of `tiles`: of all, and of rows.
  wallHashes(pictures, hashes) {
    let at = 0;
    return pictures.map(({ size: [columns, rows] }) => {
      const [across, down] = [columns, rows].map((side) => Math.ceil(side / TILE));
      const own = hashes.slice(at, (at += across * down));
      const row = (y) => own.slice(y * across, (y + 1) * across);
      const of = (some) => this.hashOf(new Uint8Array(new BigUint64Array(some).buffer));
      const each = [];
      for (let y = 0; y < down; y++) each.push(Number(BigInt.asUintN(32, of(row(y)))));
      return { hash: of(own), rows: each };
    });
  }
}
