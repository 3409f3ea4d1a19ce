// The six scenes that Shisen and Blender's Cycles both render, as binary glTF files.
//
// Each has a camera "eye".

import { createRequire } from 'node:module';
import { sphere } from '../files.mjs';
import { Glb, squares, surface } from '../glb.mjs';

const require = createRequire(import.meta.url);
const { BoxGeometry, LatheGeometry, PlaneGeometry, Quaternion, Vector2, Vector3 } =
  require(`${process.env.THREE ?? '../../../target/pairs/node_modules/three'}/build/three.cjs`);

/** Where the camera is (metres), how far it looks down (radians), and the tangent of half its angle. */
export const eye = { position: [0, 1.3, 3.4], down: 0.26, tangent: 0.4 };

// Of many triangles: Shisen's exposure goes by most of a scene's, and is to be none.
const plane = (width, height) => surface(new PlaneGeometry(width, height, 64, 64));
/** A surface of revolution about Y; its front is to the right of the way along its profile. */
function lathe(profile) {
  const geometry = new LatheGeometry(profile.map(([x, y]) => new Vector2(x, y)), 96);
  // Those at its ends are as long as the parts there.
  geometry.normalizeNormals();
  return surface(geometry);
}
/** A material that scatters and does not shine. */
function matt(file, pbr, more = {}) {
  return file.material(pbr, { ...more, extensions: { KHR_materials_specular: { specularFactor: 0 } } });
}
const lying = { rotation: [-Math.SQRT1_2, 0, 0, Math.SQRT1_2] };
/** The rotation of a node whose -Z axis is to point along a direction. */
const towards = (...direction) => {
  const turn = new Quaternion().setFromUnitVectors(new Vector3(0, 0, -1), new Vector3(...direction).normalize());
  return { rotation: turn.toArray() };
};
const about = (degrees) => ({ rotation: [0, Math.sin((degrees * Math.PI) / 360), 0, Math.cos((degrees * Math.PI) / 360)] });

/** A file with the camera; `floor` adds a tiled floor. */
function begin(floor) {
  const file = new Glb();
  const [cos, sin] = [Math.cos(eye.down / 2), -Math.sin(eye.down / 2)];
  const perspective = { yfov: 2 * Math.atan(eye.tangent), aspectRatio: 1, znear: 0.1 };
  const camera = file.add('cameras', { type: 'perspective', perspective });
  file.node({ name: 'eye', camera, translation: eye.position, rotation: [sin, 0, 0, cos] });
  if (floor) {
    const index = file.texture(256, squares(16, [235, 232, 225], [150, 150, 145]), { magFilter: 9728 });
    file.node({ mesh: file.mesh(file.primitive(plane(4, 4), matt(file, { baseColorTexture: { index } }))), ...lying });
  }
  return file;
}

const warm = [1, 0.97, 0.9];
const sun = (file, intensity, ...direction) =>
  file.light({ type: 'directional', intensity, color: warm }, [0, 3, 0], towards(...direction));

/** A clear body: the colour is that of white light after 10 cm. */
function clear(file, ior, color = [1, 1, 1]) {
  const extensions = {
    KHR_materials_transmission: { transmissionFactor: 1 },
    KHR_materials_ior: { ior },
    KHR_materials_volume: { thicknessFactor: 1, attenuationDistance: 0.1, attenuationColor: color },
  };
  return file.material({ roughnessFactor: 0 }, { extensions });
}

// Profiles of a glass: what is above the water, and what is below; and of the water: its top, and what of it reaches into
// the glass, so that nothing but their border is between them.
const dry = [[0, 0.02], [0.41, 0.02], [0.43, 0.02], [0.45, 0.04], [0.45, 0.06], [0.45, 1.18], [0.45, 1.2], [0.44, 1.22],
  [0.42, 1.22], [0.41, 1.2], [0.41, 1.18], [0.41, 0.8]];
const wet = [[0.41, 0.8], [0.41, 0.18], [0.41, 0.16], [0.39, 0.14], [0.37, 0.14], [0, 0.14]];
const top = [[0.41, 0.8], [0, 0.8]];
const hidden = [[0, 0.1], [0.43, 0.1], [0.43, 0.8], [0.41, 0.8]];
const noon = { lux: 3.4, direction: [0.6, -1, -0.9] };

/** A file of the floor and a striped wall. */
function room() {
  const file = begin(true);
  const index = file.texture(64, (u) => (Math.floor(16 * u) % 2 ? [225, 215, 190] : [60, 90, 140]), { magFilter: 9728 });
  const wall = matt(file, { baseColorTexture: { index } });
  file.node({ mesh: file.mesh(file.primitive(plane(4, 2.4), wall)), translation: [0, 1.2, -1.2] });
  return file;
}

/** Shisen's files of the nested media, which glTF has no priorities for. */
export function nested() {
  const alone = (...profiles) => {
    const file = new Glb();
    file.node({ mesh: file.mesh(...profiles.map((profile) => file.primitive(lathe(profile), file.material({})))) });
    return file;
  };
  const object = (mesh, material) => `[meshes.${mesh}]
file = "${mesh}.glb"
[[object]]
mesh = "${mesh}"
position = ${JSON.stringify(eye.position.map((at) => -at))}
${material ? `material = "${mesh}"` : ''}
`;
  const body = (name, ior, priority) => `[materials.${name}]
diffuse = [0, 0, 0]
transmission = [1, 1, 1]
index_of_refraction = ${ior}
priority = ${priority}
`;
  const toml = `ambient = [0.05, 0.05, 0.05]
[background]
zenith = [0.30, 0.50, 0.85]
horizon = [0.90, 0.90, 0.87]
nadir = [0.17, 0.14, 0.11]
${body('glass', 1.5, 2)}${body('water', 1.33, 1)}${object('room')}${object('glass', true)}${object('water', true)}
[[light]]
type = "directional"
direction = ${JSON.stringify(noon.direction)}
colour = ${JSON.stringify(warm.map((channel) => (noon.lux / Math.PI) * channel))}
`;
  return { toml, files: { room: room(), glass: alone(dry, wet), water: alone(hidden, top) } };
}

export const scenes = {
  metal: () => {
    const file = begin(false);
    const ball = sphere(96, 0.3);
    for (const [number, roughnessFactor] of [0.1, 0.25, 0.4, 0.55, 0.75, 1].entries()) {
      const baseColorFactor = number % 2 ? [0.95, 0.7, 0.35, 1] : [0.8, 0.82, 0.85, 1];
      const material = file.material({ baseColorFactor, metallicFactor: 1, roughnessFactor });
      const place = [0.9 * ((number % 3) - 1), number < 3 ? 0.85 : -0.05, 0];
      file.node({ mesh: file.mesh(file.primitive(ball, material)), translation: place });
    }
    sun(file, 2, -0.5, -1, -0.8);
    file.light({ type: 'point', intensity: 6, color: [1, 0.8, 0.6] }, [-1.6, 1.2, 1.5]);
    return file;
  },
  normals: () => {
    const file = begin(true);
    // Domes that rise from the surface, one in each cell.
    const index = file.texture(512, (u, v) => {
      const [x, y] = [u, v].map((at) => 2.4 * (((8 * at) % 1) - 0.5));
      const isDome = x * x + y * y < 1;
      const [right, up] = isDome ? [0.5 * x, -0.5 * y] : [0, 0];
      const out = Math.sqrt(1 - right * right - up * up);
      return [right, up, out].map((part) => Math.round(127.5 + 127.5 * part));
    });
    const bumpy = { normalTexture: { index } };
    const clay = matt(file, { baseColorFactor: [0.75, 0.3, 0.2, 1] }, bumpy);
    const ball = file.primitive(sphere(96, 0.6), clay);
    file.node({ mesh: file.mesh(ball), translation: [-0.6, 0.62, 0] });
    const tin = file.material({ baseColorFactor: [0.6, 0.7, 0.75, 1], metallicFactor: 1, roughnessFactor: 0.5 }, bumpy);
    file.node({ mesh: file.mesh(file.primitive(plane(1, 1.3), tin)), translation: [0.65, 0.7, -0.2], ...about(-25) });
    sun(file, 3.4, 0.4, -1, -1.2);
    return file;
  },
  leaf: () => {
    const file = begin(true);
    const index = file.texture(256, (u, v) => {
      const [x, y] = [2 * u - 1, 2 * v - 1];
      const width = 0.75 * (1 - y * y) * (0.8 + 0.2 * Math.abs(Math.sin(9 * y)));
      const hole = Math.hypot(Math.abs(x) - 0.3, y - 0.2) - 0.14;
      const inside = Math.min(width - Math.abs(x), hole);
      const vein = Math.abs(x) < 0.04 || Math.abs((y + Math.abs(x)) % 0.3) < 0.03;
      return [...(vein ? [170, 190, 80] : [60, 130, 40]), Math.round(255 * Math.min(Math.max(0.5 + 8 * inside, 0), 1))];
    });
    const material = matt(file, { baseColorTexture: { index } }, { alphaMode: 'MASK', alphaCutoff: 0.5, doubleSided: true });
    const mesh = file.mesh(file.primitive(plane(0.9, 1.2), material));
    for (const [x, z, degrees] of [[-0.75, 0.1, 30], [0, -0.3, -10], [0.75, 0.2, -50]]) {
      file.node({ mesh, translation: [x, 0.65, z], ...about(degrees) });
    }
    sun(file, 3, 0.4, -1, -0.7);
    return file;
  },
  shadow: () => {
    const file = begin(true);
    const ball = file.primitive(sphere(128, 0.45), clear(file, 1.5, [0.85, 0.95, 0.9]));
    file.node({ mesh: file.mesh(ball), translation: [-0.65, 0.5, 0.1] });
    const slab = file.primitive(surface(new BoxGeometry(0.8, 1, 0.12)), clear(file, 1.5, [0.9, 0.5, 0.35]));
    file.node({ mesh: file.mesh(slab), translation: [0.65, 0.55, 0], ...about(-20) });
    file.light({ type: 'point', intensity: 18, color: [1, 0.95, 0.85] }, [0, 2.4, 1.6]);
    return file;
  },
  nested: () => {
    const file = room();
    // The water and its borders as Cycles has them: by the ratio of indices.
    for (const [profile, ior] of [[dry, 1.5], [wet, 1.5 / 1.33], [top, 1.33]]) {
      file.node({ mesh: file.mesh(file.primitive(lathe(profile), clear(file, ior))) });
    }
    sun(file, noon.lux, ...noon.direction);
    return file;
  },
  spot: () => {
    const file = begin(true);
    const plaster = matt(file, { baseColorFactor: [0.85, 0.85, 0.82, 1] });
    file.node({ mesh: file.mesh(file.primitive(plane(4, 2.4), plaster)), translation: [0, 1.2, -1.2] });
    file.node({ mesh: file.mesh(file.primitive(sphere(96, 0.4), plaster)), translation: [0.1, 0.4, 0] });
    const spot = (color, inner, outer, place, ...target) => {
      const light = { type: 'spot', intensity: 7, color, spot: { innerConeAngle: inner, outerConeAngle: outer } };
      file.light(light, place, towards(...target.map((at, axis) => at - place[axis])));
    };
    spot([1, 0.6, 0.4], 0.05, 0.4, [-1.2, 2, 1.2], -0.5, 0.6, -1.2);
    spot([0.5, 0.8, 1], 0.3, 0.35, [1.3, 2, 1], 0.9, 0.2, -0.6);
    spot([0.8, 1, 0.7], 0, 0.5, [0, 2.4, 0.6], 0.1, 0, 0);
    return file;
  },
};
