// Writes binary glTF files and PNG pictures.

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

  /** A node with a light of KHR_lights_punctual at a place; `more` is the node's, as its rotation. */
  light(light, translation, more = {}) {
    this.use('KHR_lights_punctual');
    const lights = ((this.json.extensions ??= {}).KHR_lights_punctual ??= { lights: [] }).lights;
    const number = lights.push(light) - 1;
    this.node({ name: `light ${number}`, translation, extensions: { KHR_lights_punctual: { light: number } }, ...more });
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

/** A geometry of three.js, from the index `first` on, with v up. */
export function surface(geometry, first = 0) {
  const { position, normal, uv } = geometry.attributes;
  const places = uv.array.map((x, at) => (at % 2 ? 1 - x : x));
  const attributes = { POSITION: [position.array, 3], NORMAL: [normal.array, 3], TEXCOORD_0: [places, 2] };
  return { attributes, indices: new Uint32Array(geometry.index.array.slice(first)) };
}
