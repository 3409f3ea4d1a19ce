// Serves the page that renders by three.js, renders the same files by Shisen, and prints how far
// the pictures are apart. `run` starts it.

import { execFile, spawn } from 'node:child_process';
import { createServer } from 'node:http';
import { mkdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { basename, join } from 'node:path';
import { promisify } from 'node:util';
import { files } from './files.mjs';

const [shisen, flip, three, browser, out] = process.argv.slice(2);
const here = import.meta.dirname;
const wall = { left: -0.99, right: 0.99, bottom: -1.5, top: 0.48, z: -1.5 };
const pixels = 475;
const run = async (...words) => (await promisify(execFile)(words[0], words.slice(1))).stdout;

for (const folder of ['file', 'picture']) mkdirSync(join(out, folder), { recursive: true });
const corner = (x, y) => `[${wall[x]}, ${wall[y]}, ${wall.z}]`;
writeFileSync(join(out, 'wall.toml'), `[[wall]]
name = "front"
lower_left = ${corner('left', 'bottom')}
lower_right = ${corner('right', 'bottom')}
upper_left = ${corner('left', 'top')}
pixels = [${pixels}, ${pixels}]
`);
for (const [name, { make }] of Object.entries(files)) {
  writeFileSync(join(out, 'file', `${name}.glb`), make(true).bytes());
  writeFileSync(join(out, 'file', `${name}-without.glb`), make(false).bytes());
}

/** Renders a file by Shisen. */
async function render(name, ...more) {
  const folder = join(out, name);
  const report = JSON.parse(await run(shisen, 'cave', '--scene', join(out, 'file', `${name}.glb`),
    '--walls', join(out, 'wall.toml'), '--eyes', '1', '--scale', '1', '--samples', '16',
    '--out', folder, '--json', ...more));
  writeFileSync(join(out, 'picture', `${name}.png`), readFileSync(join(folder, 'front-centre.png')));
  rmSync(folder, { recursive: true });
  return report;
}

/** Returns the rows of the table. */
async function compare(all) {
  const rows = [];
  for (const { name, feature } of all) {
    const { exposure, not_used } = await render(name);
    if (exposure !== 0) throw new Error(`${name} is shown brighter by ${exposure} stops: it is to need none`);
    if (not_used.length) throw new Error(`of ${name} Shisen does not show ${not_used[0].what}`);
    const pictures = ['empty', `${name}-three`, name];
    const isAlone = ['unlit', 'textured'].includes(feature);
    if (!isAlone) {
      await render(`${name}-without`, '--exposure', '0');
      pictures.push(`${name}-without`);
    }
    const found = await run(flip, ...pictures.map((picture) => join(out, 'picture', `${picture}.png`)));
    const [pixels, ours, without] = found.trim().split(/\s+/).map(Number);
    const limit = isAlone ? 0.1 : without / 3;
    rows.push({ name, feature, pixels, ours, without, limit });
  }
  return rows;
}

let rows = [];
const types = { html: 'text/html', mjs: 'text/javascript', js: 'text/javascript', png: 'image/png' };
const server = createServer(async (request, response) => {
  const [, kind, ...rest] = new URL(request.url, 'http://localhost').pathname.split('/');
  const chunks = [];
  for await (const chunk of request) chunks.push(chunk);
  const body = Buffer.concat(chunks);
  try {
    if (kind === 'end') return finish(body.toString());
    if (kind === 'setting') {
      const made = Object.entries(files).map(([name, { feature }]) => ({ name, feature }));
      response.end(JSON.stringify({ wall, pixels, made }));
    } else if (kind === 'compare') {
      rows = await compare(JSON.parse(body));
      response.end();
    } else if (request.method === 'POST') {
      writeFileSync(join(out, basename(kind), basename(rest[0])), body);
      response.end();
    } else {
      const from = { three, file: join(out, 'file'), picture: join(out, 'picture') }[kind];
      const path = from ? join(from, ...rest) : join(here, basename(kind));
      response.setHeader('content-type', types[path.split('.').pop()] ?? 'application/octet-stream');
      response.end(readFileSync(path));
    }
  } catch (error) {
    response.statusCode = error.code === 'ENOENT' ? 404 : 500;
    response.end(error.stderr || error.message);
  }
});

let page;
const late = setTimeout(() => finish('the page took more than five minutes'), 300000);
server.listen(0, '127.0.0.1', () => {
  page = spawn(browser, ['--headless', '--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader',
    '--enable-unsafe-swiftshader', `--user-data-dir=${join(out, 'profile')}`,
    `http://127.0.0.1:${server.address().port}/page.html`], { stdio: 'ignore' });
  page.on('error', (error) => finish(error.message));
  page.on('exit', (code) => finish(`the browser ended by itself with ${code}`));
});

function finish(why) {
  clearTimeout(late);
  page.removeAllListeners('exit');
  page.kill();
  if (why) {
    console.error(`the pairs could not be compared: ${why}`);
    process.exit(1);
  }
  const line = (...words) => console.log(words.map((word, at) => (at < 2 ? `${word}`.padEnd(15) : `${word}`.padStart(8))).join(' '));
  line('file', 'feature', 'pixels', 'FLIP', 'limit', 'without');
  let failed = 0;
  for (const { name, feature, pixels, ours, without, limit } of rows) {
    const isFar = !(pixels > 1000 && ours <= limit);
    failed += isFar;
    line(name, feature, pixels, ...[ours, limit, without].map((x) => x?.toFixed(4) ?? '-'), isFar ? 'TOO FAR' : '');
  }
  console.log(`${rows.length} pairs, ${failed} too far apart; all pictures: ${join(out, 'picture', 'sheet.png')}`);
  process.exit(failed || rows.length !== 10 ? 1 : 0);
}
