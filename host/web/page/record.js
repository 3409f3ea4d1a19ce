// Records of frames: see host/doc/record.md.

const text = new TextEncoder();

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
    program: "page",
    arguments: ["run", "--scene", scene.desk, "--size", String(size), "--eyes", "1", "--lod", lod],
    folder: "",
    changes: [],
    fill: "background",
    scene: scene.desk,
    scene_hash: scene.hash,
    walls: null,
    tile: 32,
    pictures: ["front", "right", "floor"].map((name) => ({ name, eye: "centre", size: [size, size] })),
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
