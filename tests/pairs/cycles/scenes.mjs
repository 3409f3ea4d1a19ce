// The scenes that Shisen and Blender's Cycles both render, as binary glTF files.

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

const quaternion = (axis, angle) => new Quaternion().setFromAxisAngle(new Vector3(...axis), angle).toArray();
/** The rotation that turns -Z into a direction. */
const towards = (...direction) =>
  new Quaternion().setFromUnitVectors(new Vector3(0, 0, -1), new Vector3(...direction).normalize()).toArray();

/** Adds a thing that is turned about the vertical, in degrees. */
const add = (file, shape, material, translation, degrees = 0) =>
  file.node({ mesh: file.mesh(file.primitive(shape, material)), translation, rotation: quaternion([0, 1, 0], (degrees * Math.PI) / 180) });

/** A material that scatters and does not shine. */
const matt = (file, pbr, more = {}) =>
  file.material(pbr, { ...more, extensions: { KHR_materials_specular: { specularFactor: 0 } } });
/** A clear body: the colour is that of white light after 10 cm. */
const clear = (file, ior, attenuationColor = [1, 1, 1]) => file.material({ roughnessFactor: 0 }, { extensions: {
  KHR_materials_transmission: { transmissionFactor: 1 },
  KHR_materials_ior: { ior },
  KHR_materials_volume: { thicknessFactor: 1, attenuationDistance: 0.1, attenuationColor },
} });

const warm = [1, 0.97, 0.9];
const sun = (file, intensity, ...direction) =>
  file.light({ type: 'directional', intensity, color: warm }, [0, 3, 0], { rotation: towards(...direction) });

/** Adds the camera. */
export function look(file) {
  const perspective = { yfov: 2 * Math.atan(eye.tangent), aspectRatio: 1, znear: 0.1 };
  const camera = file.add('cameras', { type: 'perspective', perspective });
  file.node({ name: 'eye', camera, translation: eye.position, rotation: quaternion([1, 0, 0], -eye.down) });
  return file;
}

/** A file of a tiled floor; with `paint`, of a material, also of a wall. */
function begin(paint = undefined) {
  const file = new Glb();
  const index = file.texture(256, squares(16, [235, 232, 225], [150, 150, 145]), { magFilter: 9728 });
  const mesh = file.mesh(file.primitive(plane(4, 4), matt(file, { baseColorTexture: { index } })));
  file.node({ mesh, rotation: quaternion([1, 0, 0], -Math.PI / 2) });
  if (paint) add(file, plane(4, 2.4), matt(file, paint(file)), [0, 1.2, -1.2]);
  return file;
}

/** Balls of metal before the sky, by their roughness. */
function metals(...all) {
  const file = new Glb();
  for (const [number, roughnessFactor] of all.entries()) {
    const baseColorFactor = number === 1 ? [0.95, 0.7, 0.35, 1] : [0.8, 0.82, 0.85, 1];
    const material = file.material({ baseColorFactor, metallicFactor: 1, roughnessFactor });
    add(file, sphere(96, 0.36), material, [0.95 * (number - 1), 0.4, 0]);
  }
  sun(file, 2, -0.5, -1, -0.8);
  file.light({ type: 'point', intensity: 6, color: [1, 0.8, 0.6] }, [-1.6, 1.2, 1.5]);
  return file;
}

// Profiles of a glass, above its water and below, and of the water: its top, and what of it reaches into the glass, so
// that nothing but their border is between them.
const dry = [[0, 0.02], [0.41, 0.02], [0.43, 0.02], [0.45, 0.04], [0.45, 0.06], [0.45, 1.18], [0.45, 1.2], [0.44, 1.22],
  [0.42, 1.22], [0.41, 1.2], [0.41, 1.18], [0.41, 0.8]];
const wet = [[0.41, 0.8], [0.41, 0.18], [0.41, 0.16], [0.39, 0.14], [0.37, 0.14], [0, 0.14]];
const top = [[0.41, 0.8], [0, 0.8]];
const hidden = [[0, 0.1], [0.43, 0.1], [0.43, 0.8], [0.41, 0.8]];
const noon = [0.6, -1, -0.9];
const room = () => begin((file) => {
  const stripes = (u) => (Math.floor(16 * u) % 2 ? [225, 215, 190] : [60, 90, 140]);
  return { baseColorTexture: { index: file.texture(64, stripes, { magFilter: 9728 }) } };
});

/** Shisen's files of the glass of water: glTF has no priorities. */
export function nested() {
  const body = (...profiles) => {
    const file = new Glb();
    for (const profile of profiles) add(file, lathe(profile), file.material({}));
    return file;
  };
  const position = `position = [${eye.position.map((at) => -at)}]`;
  const clearness = 'diffuse = [0, 0, 0], transmission = [1, 1, 1]';
  const toml = `ambient = [0.05, 0.05, 0.05]
background = { zenith = [0.30, 0.50, 0.85], horizon = [0.90, 0.90, 0.87], nadir = [0.17, 0.14, 0.11] }
materials.glass = { ${clearness}, index_of_refraction = 1.5, priority = 2 }
materials.water = { ${clearness}, index_of_refraction = 1.33, priority = 1 }
light = [{ type = "directional", direction = [${noon}], colour = [${warm.map((channel) => (3.4 / Math.PI) * channel)}] }]
object = [${['room', 'glass', 'water'].map((mesh) => `{ mesh = "${mesh}", ${position}${mesh === 'room' ? '' : `, material = "${mesh}"`} }`)}]
${['room', 'glass', 'water'].map((mesh) => `meshes.${mesh}.file = "${mesh}.glb"`).join('\n')}
`;
  return { toml, files: { room: room(), glass: body(dry, wet), water: body(hidden, top) } };
}

/** Each scene: the difference that both renderers have by design, and its file. */
export const scenes = {
  metal: { difference: 'up to a roughness of 0.2 Shisen mirrors by one ray, also the other balls', make: () => metals(0.15, 0.3, 0.45) },
  rough: { difference: 'Shisen blurs the sky by a fit, and adds what microfacets mirror twice by another', make: () => metals(0.6, 0.8, 1) },
  normals: { difference: 'Cycles dims bumps that face a light more than their surface does', make: () => {
    const file = begin();
    // Domes that rise from the surface, one in each cell.
    const index = file.texture(512, (u, v) => {
      const [x, y] = [u, v].map((at) => 2.4 * (((8 * at) % 1) - 0.5));
      const [right, up] = x * x + y * y < 1 ? [0.5 * x, -0.5 * y] : [0, 0];
      return [right, up, Math.sqrt(1 - right * right - up * up)].map((part) => Math.round(127.5 + 127.5 * part));
    });
    const bumpy = { normalTexture: { index } };
    add(file, sphere(96, 0.6), matt(file, { baseColorFactor: [0.75, 0.3, 0.2, 1] }, bumpy), [-0.6, 0.62, 0]);
    const tin = file.material({ baseColorFactor: [0.6, 0.7, 0.75, 1], metallicFactor: 1, roughnessFactor: 0.5 }, bumpy);
    add(file, plane(1, 1.3), tin, [0.65, 0.7, -0.2], -25);
    sun(file, 3.4, 0.4, -1, -1.2);
    return file;
  } },
  leaf: { difference: 'none', make: () => {
    const file = begin();
    const index = file.texture(256, (u, v) => {
      const [x, y] = [2 * u - 1, 2 * v - 1];
      const width = 0.75 * (1 - y * y) * (0.8 + 0.2 * Math.abs(Math.sin(9 * y)));
      const inside = Math.min(width - Math.abs(x), Math.hypot(Math.abs(x) - 0.3, y - 0.2) - 0.14);
      const isVein = Math.abs((y + Math.abs(x)) % 0.3) < 0.03;
      return [...(isVein ? [170, 190, 80] : [60, 130, 40]), 255 * Math.min(Math.max(0.5 + 8 * inside, 0), 1)];
    });
    const material = matt(file, { baseColorTexture: { index } }, { alphaMode: 'MASK', doubleSided: true });
    for (const [x, z, degrees] of [[-0.75, 0.1, 30], [0, -0.3, -10], [0.75, 0.2, -50]]) {
      add(file, plane(0.9, 1.2), material, [x, 0.65, z], degrees);
    }
    sun(file, 3, 0.4, -1, -0.7);
    return file;
  } },
  shadow: { difference: 'Cycles has no highlights of points on smooth glass', make: () => {
    const file = begin();
    add(file, sphere(128, 0.45), clear(file, 1.5, [0.85, 0.95, 0.9]), [-0.65, 0.5, 0.1]);
    add(file, surface(new BoxGeometry(0.8, 1, 0.12)), clear(file, 1.5, [0.9, 0.5, 0.35]), [0.65, 0.55, 0], -20);
    file.light({ type: 'point', intensity: 18, color: [1, 0.95, 0.85] }, [0, 2.4, 1.6]);
    return file;
  } },
  nested: { difference: 'none', make: () => {
    const file = room();
    // Cycles has no priorities either: the border between glass and water has the ratio of their indices.
    add(file, lathe(dry), clear(file, 1.5));
    add(file, lathe(wet), clear(file, 1.5 / 1.33));
    add(file, lathe(top), clear(file, 1.33));
    sun(file, 3.4, ...noon);
    return file;
  } },
  spot: { difference: 'none', make: () => {
    const plaster = { baseColorFactor: [0.85, 0.85, 0.82, 1] };
    const file = begin(() => plaster);
    add(file, sphere(96, 0.4), matt(file, plaster), [0.1, 0.4, 0]);
    const spot = (color, innerConeAngle, outerConeAngle, place, ...target) => file.light(
      { type: 'spot', intensity: 7, color, spot: { innerConeAngle, outerConeAngle } }, place,
      { rotation: towards(...target.map((at, axis) => at - place[axis])) });
    spot([1, 0.6, 0.4], 0.05, 0.4, [-1.2, 2, 1.2], -0.5, 0.6, -1.2);
    spot([0.5, 0.8, 1], 0.3, 0.35, [1.3, 2, 1], 0.9, 0.2, -0.6);
    spot([0.8, 1, 0.7], 0, 0.5, [0, 2.4, 0.6], 0.1, 0, 0);
    return file;
  } },
};
