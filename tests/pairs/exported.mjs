// Makes the glTF files that three.js's own exporter writes.

import * as three from 'three';
import { GLTFExporter } from 'three/addons/exporters/GLTFExporter.js';

/** A picture of `size`² pixels that `draw` draws on a canvas of side 1. */
function texture(size, draw, more) {
  const canvas = document.createElement('canvas');
  canvas.width = canvas.height = size;
  const context = canvas.getContext('2d');
  context.scale(size, size);
  draw(context);
  return Object.assign(new three.CanvasTexture(canvas), { colorSpace: three.SRGBColorSpace }, more);
}

const matt = (more) => new three.MeshStandardMaterial({ roughness: 0.9, metalness: 0, ...more });

/** What each file compares, and its scene; `has` is false for the one without its feature. */
export const exported = {
  jpeg: { feature: 'textured', make: () => {
    const map = texture(256, (context) => {
      const colours = context.createLinearGradient(0, 0, 1, 1);
      colours.addColorStop(0, '#fff0b0');
      colours.addColorStop(0.5, '#f08098');
      colours.addColorStop(1, '#88b8ff');
      context.fillStyle = colours;
      context.fillRect(0, 0, 1, 1);
      context.fillStyle = '#203040';
      context.font = '0.5px sans-serif';
      context.fillText('Ab', 0.2, 0.7);
    }, { wrapS: three.RepeatWrapping, wrapT: three.MirroredRepeatWrapping, rotation: 0.2 });
    map.repeat.set(3, 3);
    map.offset.set(0.1, 0.3);
    map.userData.mimeType = 'image/jpeg';
    return new three.Mesh(new three.CylinderGeometry(0.75, 0.45, 1.7, 64), matt({ map }));
  } },
  vertices: { feature: 'vertex colours', make: (has) => {
    const geometry = new three.TorusKnotGeometry(0.55, 0.22, 160, 32);
    const place = geometry.getAttribute('position');
    const colours = [];
    for (let at = 0; at < place.count; at++) {
      colours.push(0.5 + place.getX(at) / 2, 0.5 + place.getY(at) / 2, 0.5 + place.getZ(at));
    }
    const clipped = colours.map((code) => Math.min(Math.max(code, 0), 1));
    if (has) geometry.setAttribute('color', new three.Float32BufferAttribute(clipped, 3));
    return new three.Mesh(geometry, matt({ vertexColors: has }));
  } },
  polished: { feature: 'metal', make: (has) => {
    const metal = { metalness: has ? 1 : 0, roughness: 0, color: 0xe0a890 };
    return new three.Mesh(new three.SphereGeometry(0.95, 96, 64), matt(metal));
  } },
  instances: { feature: 'instancing', make: (has) => {
    const count = has ? 12 : 1;
    const mesh = new three.InstancedMesh(new three.ConeGeometry(0.14, 0.4, 32), matt({ color: 0xf0c8b0 }), count);
    const pose = new three.Object3D();
    for (let at = 0; at < count; at++) {
      pose.position.set(0.5 * ((at % 4) - 1.5), 0.5 * (Math.floor(at / 4) - 1), 0.1 * (at % 3));
      // Quarter turns: boxes of instances are then as tight as those of vertices.
      pose.rotation.set(0, 0, (at * Math.PI) / 2);
      pose.scale.set(1, 0.6 + 0.06 * at, 1);
      pose.updateMatrix();
      mesh.setMatrixAt(at, pose.matrix);
    }
    return mesh;
  } },
  lights: { feature: 'lights', make: (has) => {
    const group = new three.Group();
    group.add(new three.Mesh(new three.TorusKnotGeometry(0.5, 0.18, 128, 24), matt({ color: 0xd8d8d0 })));
    if (!has) return group;
    const lamp = new three.PointLight(0xff9060, 5, 0, 2);
    lamp.position.set(-0.9, 0.5, 0.9);
    const sun = new three.DirectionalLight(0x90b0ff, 2.2);
    sun.target.position.set(0, 0, -1);
    sun.add(sun.target);
    sun.rotation.set(-0.5, 1.1, 0);
    group.add(lamp, sun);
    return group;
  } },
};

/** The bytes of a binary glTF file. */
export async function glb(object) {
  const scene = new three.Scene();
  scene.add(object);
  return new GLTFExporter().parseAsync(scene, { binary: true });
}
