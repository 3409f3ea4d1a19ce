// Renders glTF files by three.js as Shisen shows them: the same eye and wall, sun, sky and ambient
// light, and no tone mapping.

import * as three from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { exported, glb } from './exported.mjs';

const post = (path, body) => fetch(path, { method: 'POST', body });
const { wall, pixels, made } = await (await fetch('/setting')).json();
// Each pixel is the mean of so many by so many.
const FINE = 4;

const renderer = new three.WebGLRenderer({ antialias: false });
renderer.toneMapping = three.NoToneMapping;
renderer.shadowMap.enabled = true;
renderer.shadowMap.type = three.PCFShadowMap;
// What is matt gets ambient light alone, not the sky's.
const chunk = three.ShaderChunk.lights_fragment_maps;
three.ShaderChunk.lights_fragment_maps = chunk.replace(/iblIrradiance \+= [^;]*;/, '');

const near = 0.1 / -wall.z;
const camera = new three.PerspectiveCamera();
camera.projectionMatrix.makePerspective(
  near * wall.left, near * wall.right, near * wall.top, near * wall.bottom, 0.1, 100,
);
camera.projectionMatrixInverse.copy(camera.projectionMatrix).invert();

/** Shisen's sky: a gradient over the sine of the elevation. */
const sky = new three.Mesh(new three.SphereGeometry(50, 64, 32), new three.ShaderMaterial({
  side: three.BackSide,
  vertexShader: 'varying vec3 way; void main() { way = position; gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0); }',
  fragmentShader: `varying vec3 way; void main() {
    float height = normalize(way).y;
    vec3 far = height < 0.0 ? vec3(0.17, 0.14, 0.11) : vec3(0.30, 0.50, 0.85);
    gl_FragColor = vec4(mix(vec3(0.90, 0.90, 0.87), far, abs(height)), 1.0);
  }`,
}));
const surroundings = new three.PMREMGenerator(renderer).fromScene(new three.Scene().add(sky)).texture;

/** A PNG picture of a scene: linear light is averaged, then encoded. */
async function picture(scene) {
  const size = FINE * pixels;
  const target = new three.WebGLRenderTarget(size, size, { type: three.FloatType });
  renderer.setRenderTarget(target);
  renderer.render(scene, camera);
  const light = new Float32Array(4 * size * size);
  renderer.readRenderTargetPixels(target, 0, 0, size, size, light);
  target.dispose();
  const codes = new Uint8ClampedArray(4 * pixels * pixels).fill(255);
  for (let y = 0; y < pixels; y++) {
    for (let x = 0; x < pixels; x++) {
      for (let channel = 0; channel < 3; channel++) {
        let sum = 0;
        for (let sample = 0; sample < FINE * FINE; sample++) {
          const row = size - 1 - (FINE * y + Math.floor(sample / FINE));
          // Shisen's samples are not clipped before the mean either.
          sum += light[4 * (row * size + FINE * x + (sample % FINE)) + channel];
        }
        const mean = Math.min(sum / (FINE * FINE), 1);
        const code = mean <= 0.0031308 ? 12.92 * mean : 1.055 * mean ** (1 / 2.4) - 0.055;
        codes[4 * (y * pixels + x) + channel] = 255 * code;
      }
    }
  }
  const canvas = new OffscreenCanvas(pixels, pixels);
  canvas.getContext('2d').putImageData(new ImageData(codes, pixels, pixels), 0, 0);
  return canvas.convertToBlob();
}

function shadowed(light) {
  light.castShadow = true;
  light.shadow.mapSize.set(2048, 2048);
  light.shadow.normalBias = 0.01;
  // A sun's shadow camera stands where its node does, which may be amid the model.
  light.shadow.camera.near = light.isDirectionalLight ? -5 : 0.02;
  return light;
}

/** A file as Shisen places and lights it. */
async function scene(path) {
  const model = (await new GLTFLoader().loadAsync(path)).scene;
  const box = new three.Box3().setFromObject(model, true);
  const middle = box.getCenter(new three.Vector3());
  model.position.set(-middle.x, wall.bottom - box.min.y, -2.5 - middle.z);
  let hasLight = false;
  model.traverse((node) => {
    node.castShadow = node.receiveShadow = node.isMesh === true;
    if (node.isLight) {
      hasLight = true;
      shadowed(node);
    }
    if (node.material?.metalness > 0) node.material.envMap = surroundings;
  });
  const all = new three.Scene().add(sky, model);
  // Shisen's units of light are those of a white surface that faces it.
  all.add(new three.AmbientLight(0xffffff, (hasLight ? 0.05 : 0.2) * Math.PI));
  if (!hasLight) {
    const sun = shadowed(new three.DirectionalLight(0xffffff, 0.8 * Math.PI));
    sun.target.position.set(0, -0.5, -2.5);
    sun.position.set(0.4, 1, 0.6).multiplyScalar(3).add(sun.target.position);
    Object.assign(sun.shadow.camera, { left: -1.5, right: 1.5, bottom: -1.5, top: 1.5 });
    all.add(sun, sun.target);
  }
  return all;
}

const all = [...made];
for (const [name, { feature, make }] of Object.entries(exported)) {
  await post(`/file/${name}.glb`, await glb(make(true)));
  await post(`/file/${name}-without.glb`, await glb(make(false)));
  all.push({ name, feature });
}
await post('/picture/empty.png', await picture(new three.Scene().add(sky)));
for (const { name } of all) {
  await post(`/picture/${name}-three.png`, await picture(await scene(`/file/${name}.glb`)));
}
const report = await post('/compare', JSON.stringify(all));
if (!report.ok) throw new Error(await report.text());

// Of each file Shisen's picture, three.js's, and Shisen's without the feature.
const [side, columns] = [240, 2];
const sheet = new OffscreenCanvas(columns * 3 * side, Math.ceil(all.length / columns) * side);
const context = sheet.getContext('2d');
for (const [number, { name }] of all.entries()) {
  for (const [place, kind] of ['', '-three', '-without'].entries()) {
    const found = await fetch(`/picture/${name}${kind}.png`);
    if (!found.ok) continue;
    const image = await createImageBitmap(await found.blob());
    const [x, y] = [(number % columns) * 3 + place, Math.floor(number / columns)].map((at) => at * side);
    context.drawImage(image, x, y, side, side);
    context.fillText(`${name}${kind}`, x + 4, y + side - 4);
  }
}
await post('/picture/sheet.png', await sheet.convertToBlob());
await end('');
