// Renders the scenes of cycles/ by Shisen and by Blender's Cycles, and prints how far the pictures are apart. `run` starts
// it. Metals have limits of their own, since what they show of the sky is a fit. The limit of the others is so low that
// a picture without its scene's effect exceeds it.

import { execFileSync } from 'node:child_process';
import { copyFileSync, mkdirSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { eye, look, nested, scenes } from './cycles/scenes.mjs';

const [shisen, flip, out] = process.argv.slice(2);
const side = 256;
const limitOf = (name) => ({ metal: 0.1, rough: 0.2 })[name] ?? 0.05;
const run = (...words) => execFileSync(words[0], words.slice(1), { encoding: 'utf8', maxBuffer: 2 ** 26, stdio: ['ignore', 'pipe', 'inherit'] });

const at = (...names) => join(out, ...names);
mkdirSync(at('cycles'), { recursive: true });
// What the camera sees, 1.5 m before it.
const [cos, sin] = [Math.cos(eye.down), Math.sin(eye.down)];
const corner = (x, y) => `[${1.5 * x}, ${1.5 * (y * cos - sin)}, ${-1.5 * (cos + y * sin)}]`;
writeFileSync(at('view.toml'), `[[wall]]
name = "front"
lower_left = ${corner(-eye.tangent, -eye.tangent)}
lower_right = ${corner(eye.tangent, -eye.tangent)}
upper_left = ${corner(-eye.tangent, eye.tangent)}
pixels = [${side}, ${side}]
`);
const { toml, files } = nested();
writeFileSync(at('nested.toml'), toml);
for (const [name, file] of Object.entries(files)) writeFileSync(at(`${name}.glb`), file.bytes());
for (const [name, { make }] of Object.entries(scenes)) {
  writeFileSync(at(`${name}.glb`), look(make()).bytes());
  const scene = name === 'nested' ? [at('nested.toml')] : [at(`${name}.glb`), '--scale', '1', '--camera', 'eye'];
  const report = JSON.parse(run(shisen, 'cave', '--scene', ...scene, '--walls', at('view.toml'), '--eyes', '1',
    '--samples', '16', '--depth', '8', '--out', at(name), '--json'));
  if (report.exposure || report.not_used.length) throw new Error(`Shisen does not show ${name} as it is`);
  copyFileSync(at(name, 'front-centre.png'), at(`${name}.png`));
}
run('blender', '--background', '--python-exit-code', '1', '--python', join(import.meta.dirname, 'cycles/render.py'), '--',
  at('cycles'), `${side}`, '128', ...Object.keys(scenes).map((name) => at(`${name}.glb`)));

let failed = 0;
const line = (name, ...words) => console.log(name.padEnd(8), ...words.slice(0, 3).map((word) => `${word}`.padStart(7)), ...words.slice(3));
line('scene', 'pixels', 'FLIP', 'limit', ' difference by design');
for (const [name, { difference }] of Object.entries(scenes)) {
  const pictures = [at('cycles', 'sky.png'), at('cycles', `${name}.png`), at(`${name}.png`)];
  const [pixels, apart] = run(flip, ...pictures).trim().split(/\s+/).map(Number);
  const isFar = !(pixels > 1000 && apart <= limitOf(name));
  failed += isFar;
  line(name, pixels, apart.toFixed(4), limitOf(name), ` ${difference}${isFar ? ' TOO FAR' : ''}`);
}
console.log(`${failed} scenes too far from Cycles; pictures: ${out}, and Cycles' in ${at('cycles')}`);
process.exit(failed ? 1 : 0);
