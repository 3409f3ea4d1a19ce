// Opens the page in a browser as a person would: every scene, a desk's size and a phone's, light and
// dark; then a desk's record, and the measurement of an eye. Fails where nothing is drawn or anything
// is complained about.
import fs from "node:fs";
import path from "node:path";
import { openBrowser } from "./browser.mjs";

const [, , url, shots, record] = process.argv;
const { send, value, complaints, close } = await openBrowser();
const sleep = (ms) => new Promise((done) => setTimeout(done, ms));
const until = async (expression) => {
  for (let turn = 0; turn < 1000; turn += 1) {
    if (await value(expression)) return;
    await sleep(30);
  }
  throw new Error(`never: ${expression}; the page says: ${await value("document.getElementById('message').textContent")}`);
};
const shot = async (file) => {
  const { data } = await send("Page.captureScreenshot", { format: "png" });
  fs.writeFileSync(path.join(shots, file), Buffer.from(data, "base64"));
};
// How many colours the walls have, of copies: a canvas that is read back is another one.
const COLOURS = `new Set([...document.querySelectorAll("#room canvas")].flatMap((one) => {
  const copy = new OffscreenCanvas(one.width, one.height).getContext("2d");
  copy.drawImage(one, 0, 0);
  return [...new Uint32Array(copy.getImageData(0, 0, one.width, one.height).data.buffer)];
})).size`;

for (const [width, height, scheme] of [[1280, 900, "light"], [390, 844, "dark"]]) {
  await send("Emulation.setDeviceMetricsOverride", { width, height, deviceScaleFactor: 1, mobile: width < 600 });
  await send("Emulation.setEmulatedMedia", { features: [{ name: "prefers-color-scheme", value: scheme }] });
  await send("Page.navigate", { url });
  const begun = Date.now();
  await until("document.body?.dataset.frames > 0");
  console.log(`${width} × ${height}: the first picture after ${Date.now() - begun} ms`);
  for (const scene of ["animal", "gallery", "prism", "dome"]) {
    const frames = await value("Number(document.body.dataset.frames)");
    await value(`document.querySelector('#scenes input[value=${scene}]').click()`);
    if (scene !== "animal") await until(`Number(document.body.dataset.frames) > ${frames}`);
    const colours = await value(COLOURS);
    if (!(colours > (scene === "dome" ? 3 : 100))) throw new Error(`${scene} has ${colours} colours`);
    await shot(`${width}-${scene}.png`);
  }
}
// However often it is opened, all of it comes.
for (let turn = 0; turn < 20; turn += 1) {
  await send("Page.navigate", { url });
  await until("document.body?.dataset.frames > 0");
}
// A record plays along its time line, which ends where it ends.
await send("Emulation.setDeviceMetricsOverride", { width: 1280, height: 900, deviceScaleFactor: 1, mobile: false });
await value("document.querySelector('#scenes input[value=animal]').click()");
const { root } = await send("DOM.getDocument");
const { nodeId } = await send("DOM.querySelector", { nodeId: root.nodeId, selector: "#record" });
await send("DOM.setFileInputFiles", { nodeId, files: [record] });
await until("!document.getElementById('play').disabled");
const moment = (name) => value(`document.getElementById("moment")${name}`);
const before = [await value(COLOURS), await value("document.getElementById('moment-text').textContent")];
const frames = await value("Number(document.body.dataset.frames)");
await moment(".value = 30, document.getElementById('moment').dispatchEvent(new Event('input'))");
await until(`Number(document.body.dataset.frames) > ${frames}`);
const after = [await value(COLOURS), await value("document.getElementById('moment-text').textContent")];
if (!(Number(await moment(".max")) === 39 && after[0] > 100 && parseFloat(after[1]) > parseFloat(before[1]))) {
  throw new Error(`the record played ${JSON.stringify([before, after])}`);
}
// At rest it is compared with what the desk recorded.
await until("document.getElementById('compared').textContent.startsWith('the same as recorded')");
await shot("1280-record.png");
// An eye is measured by keys, and what is found is shown.
await value("document.getElementById('measure').click()");
await until("document.getElementById('fovea').open");
for (const name of ["next", "begin"]) await value(`document.querySelector("#fovea [name=${name}]").click()`);
await shot("1280-fovea.png");
for (let key = 0; key < 200 && (await value("document.getElementById('fovea').open")); key += 1) {
  const name = ["ArrowRight", "ArrowDown", "ArrowLeft", "ArrowUp"][key % 4];
  for (const type of ["keyDown", "keyUp"]) await send("Input.dispatchKeyEvent", { type, key: name });
  await sleep(250);
}
await until("document.getElementById('eye').textContent.includes('You see')");
await shot("1280-eye.png");
close();
if (complaints.length > 0) throw new Error(complaints.join("\n"));
process.exit(0);
