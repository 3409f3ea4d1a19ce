// Writes binary glTF files and PNG pictures, and makes the surfaces that they hold.

import { deflateSync, crc32 } from 'node:zlib';

/** A glTF file that grows: each method adds one thing and returns its number. */
export class Glb {
  json = { asset: { version: '2.0' }, scene: 0, scenes: [{ nodes: [] }] };
  chunks = [];
  length = 0;

  add(kind, item) {
    return (this.json[kind] ??= []).push(item) - 1;
  }

  use(name) {
    const used = (this.json.extensionsUsed ??= []);
    if (!used.includes(name)) used.push(name);
  }

  view(bytes) {
    const view = { buffer: 0, byteOffset: this.length, byteLength: bytes.length };
    const padding = Buffer.alloc(-bytes.length & 3);
    this.chunks.push(bytes, padding);
    this.length += bytes.length + padding.length;
    return this.add('bufferViews', view);
  }

  /** `array` is a Float32Array or a Uint32Array of items of `width` numbers. */
  accessor(array, width, isPosition = false) {
    const item = {
      bufferView: this.view(Buffer.from(array.buffer)),
      componentType: array instanceof Float32Array ? 5126 : 5125,
      count: array.length / width,
      type: width === 1 ? 'SCALAR' : `VEC${width}`,
    };
    if (isPosition) {
      const ends = (least) => [0, 1, 2].map((axis) => {
        const of = array.filter((_, at) => at % 3 === axis);
        return of.reduce((a, b) => (least ? Math.min(a, b) : Math.max(a, b)));
      });
      Object.assign(item, { min: ends(true), max: ends(false) });
    }
    return this.add('accessors', item);
  }

  /** `sampler` is glTF's; `colour(u, v)` returns three or four codes, v down. */
  texture(size, colour, sampler = {}) {
    const image = { bufferView: this.view(png(size, colour)), mimeType: 'image/png' };
    return this.add('textures', {
      source: this.add('images', image),
      sampler: this.add('samplers', sampler),
    });
  }

  /** `extensions` are the material's by their names. */
  material(pbr, more = {}) {
    Object.keys(more.extensions ?? {}).forEach((name) => this.use(name));
    const rough = { metallicFactor: 0, roughnessFactor: 0.9 };
    return this.add('materials', { pbrMetallicRoughness: { ...rough, ...pbr }, ...more });
  }

  /** A primitive of a surface; `leaves` names attributes to leave out. */
  primitive(surface, material, leaves = []) {
    const attributes = {};
    for (const [name, [array, width]] of Object.entries(surface.attributes)) {
      if (leaves.includes(name)) continue;
      attributes[name] = this.accessor(array, width, name === 'POSITION');
    }
    return { attributes, indices: this.accessor(surface.indices, 1), material };
  }

  mesh(...primitives) {
    return this.add('meshes', { primitives });
  }

  node(node, parent = this.json.scenes[0].nodes) {
    const number = this.add('nodes', node);
    parent.push(number);
    return number;
  }

  /** A node with a light of KHR_lights_punctual at a place. */
  light(light, translation) {
    this.use('KHR_lights_punctual');
    const lights = ((this.json.extensions ??= {}).KHR_lights_punctual ??= { lights: [] }).lights;
    const number = lights.push(light) - 1;
    this.node({ translation, extensions: { KHR_lights_punctual: { light: number } } });
  }

  bytes() {
    this.json.buffers = [{ byteLength: this.length }];
    let json = Buffer.from(JSON.stringify(this.json));
    json = Buffer.concat([json, Buffer.alloc(-json.length & 3, ' ')]);
    const head = Buffer.from('glTF\x02\0\0\0\0\0\0\0\0\0\0\0JSON\0\0\0\0BIN\0', 'latin1');
    head.writeUInt32LE(28 + json.length + this.length, 8);
    head.writeUInt32LE(json.length, 12);
    head.writeUInt32LE(this.length, 20);
    return Buffer.concat([head.subarray(0, 20), json, head.subarray(20), ...this.chunks]);
  }
}

function png(size, colour) {
  const rows = Buffer.alloc(size * (4 * size + 1));
  for (let y = 0; y < size; y++) {
    for (let x = 0; x < size; x++) {
      const [r, g, b, a = 255] = colour((x + 0.5) / size, (y + 0.5) / size);
      rows.set([r, g, b, a], y * (4 * size + 1) + 1 + 4 * x);
    }
  }
  const chunk = (name, data) => {
    const body = Buffer.concat([Buffer.from(name), data]);
    const [length, sum] = [Buffer.alloc(4), Buffer.alloc(4)];
    length.writeUInt32BE(data.length);
    sum.writeUInt32BE(crc32(body));
    return Buffer.concat([length, body, sum]);
  };
  const header = Buffer.from([0, 0, 0, 0, 0, 0, 0, 0, 8, 6, 0, 0, 0]);
  header.writeUInt32BE(size, 0);
  header.writeUInt32BE(size, 4);
  const signature = Buffer.from('\x89PNG\r\n\x1a\n', 'latin1');
  const all = [chunk('IHDR', header), chunk('IDAT', deflateSync(rows)), chunk('IEND', Buffer.alloc(0))];
  return Buffer.concat([signature, ...all]);
}

/** Squares of two colours, `count` along each side, with one corner in a third colour, so that no
 * turned or mirrored picture is the same. */
export const squares = (count, one, other, corner = one) => (u, v) => {
  if (u < 1 / count && v < 1 / count) return corner;
  return (Math.floor(u * count) + Math.floor(v * count)) % 2 ? one : other;
};

/** A grid of columns × rows quads over `at(u, v)`, u and v from 0 to 1, whose front is where
 * u × v points. */
export function grid(columns, rows, at) {
  const count = (columns + 1) * (rows + 1);
  const arrays = [3, 3, 2].map((width) => new Float32Array(count * width));
  const indices = [];
  for (let row = 0, vertex = 0; row <= rows; row++) {
    for (let column = 0; column <= columns; column++, vertex++) {
      const [u, v] = [column / columns, row / rows];
      arrays[0].set(at(u, v), 3 * vertex);
      arrays[1].set(normal(at, u, v), 3 * vertex);
      arrays[2].set([u, 1 - v], 2 * vertex);
      if (row < rows && column < columns) {
        const above = vertex + columns + 1;
        indices.push(vertex, vertex + 1, above + 1, vertex, above + 1, above);
      }
    }
  }
  const [positions, normals, places] = arrays;
  const attributes = { POSITION: [positions, 3], NORMAL: [normals, 3], TEXCOORD_0: [places, 2] };
  return { attributes, indices: new Uint32Array(indices) };
}

function normal(at, u, v) {
  // A step away from the ends: where a side of the grid is one point there is no slope.
  const [s, t] = [u, v].map((x) => Math.min(Math.max(x, 1e-3), 1 - 1e-3));
  const slope = (one, other) => at(...one).map((x, axis) => x - at(...other)[axis]);
  const [a, b, c] = slope([s + 1e-4, t], [s - 1e-4, t]);
  const [d, e, f] = slope([s, t + 1e-4], [s, t - 1e-4]);
  const cross = [b * f - c * e, c * d - a * f, a * e - b * d];
  return cross.map((x) => x / Math.hypot(...cross));
}

const turn = 2 * Math.PI;

export const sphere = (columns, radius = 1) => grid(columns, columns >> 1, (u, v) => {
  const [sin, y] = [Math.sin(Math.PI * v), -Math.cos(Math.PI * v)];
  return [Math.sin(turn * u) * sin, y, Math.cos(turn * u) * sin].map((x) => radius * x);
});

/** A ring round the Z axis. */
export const torus = (columns, radius, tube) => grid(columns, columns >> 1, (u, v) => {
  const across = radius + tube * Math.cos(turn * v);
  return [across * Math.cos(turn * u), across * Math.sin(turn * u), tube * Math.sin(turn * v)];
});

/** An open tube along Y from −½ to ½, of radius 1. */
export const tube = (columns) => grid(columns, 1, (u, v) => [Math.sin(turn * u), v - 0.5, Math.cos(turn * u)]);

/** Five or six faces of the cube from −½ to ½, of `cells`² quads each; inside out for a room, and
 * then without the face to the viewer. */
export function box(cells, isRoom = false) {
  const sides = [[0, 1, 2], [1, 2, 0], [2, 0, 1]].flatMap((axes) => [[axes, 0.5], [axes, -0.5]]);
  const faces = sides.filter(([axes, side]) => !(isRoom && axes[2] === 2 && side > 0));
  const grids = faces.map(([axes, side]) => grid(cells, cells, (u, v) => {
    const point = [0, 0, 0];
    const flip = (side < 0) !== isRoom;
    point[axes[0]] = (flip ? 1 - u : u) - 0.5;
    point[axes[1]] = v - 0.5;
    point[axes[2]] = side;
    return point;
  }));
  return grids.reduce(joined);
}

function joined(one, other) {
  const first = one.attributes.POSITION[0].length / 3;
  const attributes = {};
  for (const [name, [array, width]] of Object.entries(one.attributes)) {
    attributes[name] = [new Float32Array([...array, ...other.attributes[name][0]]), width];
  }
  const indices = [...one.indices, ...other.indices.map((index) => index + first)];
  return { attributes, indices: new Uint32Array(indices) };
}
