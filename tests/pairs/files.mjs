// Makes the glTF files of ours that tests/pairs/run compares, and larger ones to look at:
//
//   node tests/pairs/files.mjs FOLDER [TRIANGLES]
//
// writes helmet.glb, truck.glb and room.glb, each of about so many triangles (50,000). Their
// geometries are three.js's, which `tests/pairs/run --prepare` installs; THREE names its folder
// where CARGO_TARGET_DIR is set.

import { mkdirSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { fileURLToPath } from 'node:url';
import { Glb, squares, surface } from './glb.mjs';

const require = createRequire(import.meta.url);
const { BoxGeometry, CylinderGeometry, PlaneGeometry, SphereGeometry, TorusGeometry } =
  require(`${process.env.THREE ?? '../../target/pairs/node_modules/three'}/build/three.cjs`);

export const sphere = (columns, radius, ...part) => surface(new SphereGeometry(radius, columns, columns >> 1, ...part));
/** A ring round the Z axis. */
const torus = (columns, radius, tube) => surface(new TorusGeometry(radius, tube, columns >> 1, columns));
const cube = (cells) => new BoxGeometry(1, 1, 1, cells, cells, cells);

const [red, white, blue, green, black] = [[200, 40, 30], [230, 225, 215], [40, 70, 180], [60, 160, 70], [0, 0, 0]];

/** What each file compares, and the file; `has` is false for the one without its feature. */
export const files = {
  unlit: { feature: 'unlit', make: () => {
    const file = new Glb();
    const baseColorTexture = { index: file.texture(64, squares(8, red, white, blue)) };
    const unlit = { extensions: { KHR_materials_unlit: {} } };
    const painted = file.material({ baseColorTexture, baseColorFactor: [0.9, 1, 0.6, 1] }, unlit);
    file.node({ mesh: file.mesh(file.primitive(torus(96, 0.7, 0.3), painted)) });
    return file;
  } },
  // On the second set of coordinates, turned, mirrored one way and clamped the other. It is as wide
  // as high: three.js turns before it scales, and glTF scales first.
  textured: { feature: 'textured', make: () => {
    const file = new Glb();
    const sampler = { wrapS: 33648, wrapT: 33071, magFilter: 9728 };
    const index = file.texture(16, squares(4, green, white, red), sampler);
    file.use('KHR_texture_transform');
    const moved = { offset: [0.2, 0.1], rotation: 0.3, scale: [2, 2] };
    const baseColorTexture = { index, texCoord: 1, extensions: { KHR_texture_transform: moved } };
    const ball = sphere(96, 0.95);
    const own = ball.attributes.TEXCOORD_0;
    ball.attributes.TEXCOORD_1 = [own[0].map((x, at) => (at % 2 ? x : 1 - x)), 2];
    // The page's sky is mirrored by metals alone.
    file.use('KHR_materials_specular');
    const matt = { extensions: { KHR_materials_specular: { specularFactor: 0 } } };
    file.node({ mesh: file.mesh(file.primitive(ball, file.material({ baseColorTexture }, matt))) });
    return file;
  } },
  emission: { feature: 'emission', make: (has) => {
    const file = new Glb();
    const emissiveTexture = { index: file.texture(64, squares(4, red, black, blue)) };
    const extensions = { KHR_materials_emissive_strength: { emissiveStrength: 1.2 } };
    const lamp = { emissiveTexture, emissiveFactor: [0.5, 0.5, 0.4], extensions };
    const material = file.material({ baseColorFactor: [0.4, 0.4, 0.4, 1] }, has ? lamp : {});
    file.node({ mesh: file.mesh(file.primitive(sphere(96, 0.95), material)) });
    return file;
  } },
  // Metal where its texture says so, and nothing between. It is smooth, and round: three.js mirrors
  // the sky alone, and Shisen no rough metal.
  metal: { feature: 'metal', make: (has) => {
    const file = new Glb();
    const index = file.texture(128, squares(4, [0, 0, 255], [0, 255, 0]), { magFilter: 9728, minFilter: 9728 });
    const metal = { metallicRoughnessTexture: { index }, metallicFactor: 1, roughnessFactor: 1 };
    const gold = { baseColorFactor: [1, 0.77, 0.34, 1] };
    const material = file.material(has ? { ...gold, ...metal } : gold);
    file.node({ mesh: file.mesh(file.primitive(sphere(128, 0.95), material)) });
    return file;
  } },
  lamp: { feature: 'lights', make: (has) => {
    const file = new Glb();
    const baseColorTexture = { index: file.texture(64, squares(8, white, [150, 150, 140])) };
    const material = file.material({ baseColorTexture });
    const screen = surface(new PlaneGeometry(1.9, 1.7, 8, 8));
    file.node({ mesh: file.mesh(file.primitive(screen, material)), translation: [0, 0.85, 0] });
    file.node({ mesh: file.mesh(file.primitive(sphere(64, 0.35), material)), translation: [0, 0.8, 0.5] });
    if (has) file.light({ type: 'point', intensity: 4, color: [1, 0.8, 0.5] }, [0.7, 1.3, 0.9]);
    return file;
  } },
};

const side = (triangles, grids) => Math.max(4, Math.round(Math.sqrt(triangles / (2 * grids))));

/** Several textured shells of metal and leather. */
function helmet(triangles) {
  const file = new Glb();
  const columns = side(triangles, 4.5);
  const half = Math.PI / 2;
  const noise = (u, v) => 0.5 + 0.5 * Math.sin(40 * u + 9 * Math.sin(23 * v)) * Math.sin(31 * v);
  const tones = [[110, 60, 35], [190, 190, 195], [60, 62, 58], [150, 110, 50]];
  const materials = tones.map((tone, number) => {
    const base = file.texture(256, (u, v) => tone.map((code) => code * (0.7 + 0.3 * noise(u, v))));
    const isMetal = number % 2 ? 255 : 0;
    const metal = file.texture(128, (u, v) => [0, 60 + 120 * noise(2 * u, v), isMetal]);
    const metallicRoughnessTexture = { index: metal };
    return file.material({ baseColorTexture: { index: base }, metallicRoughnessTexture, metallicFactor: 1, roughnessFactor: 1 });
  });
  // A part of a ball between two heights, in radians, as wide as `open` about the front.
  const shell = (radius, from, to, open) => sphere(2 * columns, radius, half - open / 2, open, half - to, to - from);
  const parts = [
    [shell(0.5, -0.2, half, 4 * half), 0, {}],
    [shell(0.52, -0.9, 0.1, 2.6 * half), 2, { rotation: [0, 1, 0, 0] }],
    [shell(0.54, 0.25, 0.45, 4 * half), 1, {}],
    [torus(columns, 0.14, 0.04), 3, { translation: [-0.17, 0.05, 0.46] }],
    [torus(columns, 0.14, 0.04), 3, { translation: [0.17, 0.05, 0.46] }],
    [sphere(columns, 0.3), 0, { translation: [0, -0.3, 0] }],
  ];
  const head = { children: [], scale: [0.85, 1, 1] };
  file.node(head);
  for (const [surface, material, node] of parts) {
    const mesh = file.mesh(file.primitive(surface, materials[material]));
    file.node({ mesh, ...node }, head.children);
  }
  return file;
}

/** Many nodes, some without coordinates; paint, chrome and glass. */
function truck(triangles) {
  const file = new Glb();
  const cells = side(triangles, 142);
  const paint = file.material({ baseColorFactor: [0.7, 0.12, 0.08, 1], roughnessFactor: 0.4 });
  const chrome = file.material({ baseColorFactor: [0.9, 0.9, 0.92, 1], metallicFactor: 1, roughnessFactor: 0.05 });
  const rubber = file.material({ baseColorFactor: [0.05, 0.05, 0.05, 1] });
  const wood = file.material({ baseColorTexture: { index: file.texture(64, squares(8, [150, 105, 60], [120, 80, 45])) } });
  const glass = file.material({ roughnessFactor: 0 }, { extensions: { KHR_materials_transmission: { transmissionFactor: 0.9 } } });
  const lamp = file.material({}, { emissiveFactor: [1, 0.9, 0.6] });
  const block = surface(cube(cells));
  const plain = ['TEXCOORD_0'];
  const [painted, shiny, planks, pane] = [[paint, plain], [chrome, plain], [wood, []], [glass, plain]]
    .map(([material, leaves]) => file.mesh(file.primitive(block, material, leaves)));
  const wheel = file.mesh(
    file.primitive(torus(2 * cells, 0.3, 0.12), rubber, plain),
    file.primitive(sphere(cells, 0.17), chrome, plain),
  );
  const light = file.mesh(file.primitive(sphere(cells, 0.1), lamp, plain));
  const whole = { children: [], rotation: [0, Math.sin(-0.3), 0, Math.cos(-0.3)] };
  file.node(whole);
  const part = (mesh, translation, scale = [1, 1, 1]) => file.node({ mesh, translation, scale }, whole.children);
  part(painted, [0, 0.6, 0], [1.2, 0.25, 3.6]);
  part(painted, [0, 1, 0.9], [1.2, 0.6, 1.1]);
  part(painted, [0, 1.75, 0.9], [1.2, 0.1, 1.1]);
  for (const x of [-0.55, 0.55]) for (const z of [0.4, 1.4]) part(painted, [x, 1.5, z], [0.08, 0.5, 0.08]);
  part(pane, [0, 1.5, 1.43], [1, 0.4, 0.02]);
  for (const x of [-0.58, 0.58]) part(pane, [x, 1.5, 0.9], [0.02, 0.4, 0.9]);
  part(shiny, [0, 0.5, 1.85], [1.3, 0.15, 0.1]);
  for (let number = 0; number < 7; number++) part(shiny, [0.12 * (number - 3), 0.95, 1.46], [0.04, 0.4, 0.04]);
  for (const x of [-0.6, 0.6]) part(planks, [x, 0.95, -0.75], [0.06, 0.5, 1.9]);
  for (const z of [-1.7, 0.2]) part(planks, [0, 0.95, z], [1.2, 0.5, 0.06]);
  for (const x of [-0.45, 0.45]) part(light, [x, 0.7, 1.82]);
  const sideways = [0, Math.SQRT1_2, 0, Math.SQRT1_2];
  for (const x of [-0.65, 0.65]) {
    for (const z of [-1.1, 1.2]) {
      file.node({ mesh: wheel, translation: [x, 0.42, z], rotation: sideways }, whole.children);
    }
  }
  return file;
}

/** A room without its front, two lamps in it, and rows of the same things. */
function room(triangles) {
  const file = new Glb();
  const cells = side(triangles, 46);
  const paper = { index: file.texture(64, squares(16, [205, 190, 165], [195, 178, 150])) };
  const wall = file.material({ baseColorTexture: paper }, { doubleSided: true });
  const table = file.material({ baseColorFactor: [0.4, 0.22, 0.1, 1], roughnessFactor: 0.5 });
  const mirror = file.material({ baseColorFactor: [0.95, 0.95, 0.95, 1], metallicFactor: 1, roughnessFactor: 0 });
  const cup = file.material({ baseColorFactor: [0.2, 0.35, 0.6, 1], roughnessFactor: 0.3 });
  const bulb = file.material({}, { emissiveFactor: [1, 0.85, 0.6] });
  const block = file.primitive(surface(cube(cells)), table);
  // Its first face is moved to the front, which is open.
  const walls = file.primitive(surface(cube(cells), 6 * cells * cells), wall);
  const turned = [0, -Math.SQRT1_2, 0, Math.SQRT1_2];
  file.node({ mesh: file.mesh(walls), translation: [0, 1.4, 0], rotation: turned, scale: [3, 2.8, 4] });
  file.node({ mesh: file.mesh(block), translation: [0, 0.75, 0], scale: [1.6, 0.06, 0.9] });
  file.node({ mesh: file.mesh({ ...block, material: mirror }), translation: [0, 1.7, -1.47], scale: [1.2, 0.8, 0.04] });
  const instances = (mesh, places, size) => {
    file.use('EXT_mesh_gpu_instancing');
    const attributes = {
      TRANSLATION: file.accessor(new Float32Array(places.flat()), 3),
      SCALE: file.accessor(new Float32Array(places.flatMap(() => size)), 3),
    };
    file.node({ mesh, extensions: { EXT_mesh_gpu_instancing: { attributes } } });
  };
  instances(file.mesh(block), [[-0.7, 0.37, -0.35], [0.7, 0.37, -0.35], [-0.7, 0.37, 0.35], [0.7, 0.37, 0.35]], [0.07, 0.74, 0.07]);
  const tube = surface(new CylinderGeometry(1, 1, 1, cells, 1, true));
  const row = [-3, -2, -1, 0, 1, 2, 3];
  instances(file.mesh(file.primitive(sphere(cells, 1), cup)), row.map((x) => [0.2 * x, 0.86, 0.1]), [0.08, 0.08, 0.08]);
  instances(file.mesh(file.primitive(tube, mirror)), row.map((x) => [0.2 * x, 0.9, -0.2]), [0.05, 0.24, 0.05]);
  const ball = file.mesh(file.primitive(sphere(cells, 0.08), bulb));
  for (const x of [-1.2, 1.2]) {
    file.node({ mesh: ball, translation: [x, 2.4, -0.6] });
    file.light({ type: 'point', intensity: 8, color: [1, 0.85, 0.6] }, [x, 2.2, -0.6]);
  }
  return file;
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const [, , folder, triangles = '50000'] = process.argv;
  if (!folder || !(Number(triangles) >= 1000 && Number(triangles) <= 2e6)) {
    console.error('node tests/pairs/files.mjs FOLDER [TRIANGLES]: a folder, and 1000 to 2000000 triangles');
    process.exit(2);
  }
  mkdirSync(folder, { recursive: true });
  for (const make of [helmet, truck, room]) {
    writeFileSync(`${folder}/${make.name}.glb`, make(Number(triangles)).bytes());
  }
}
