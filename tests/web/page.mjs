// Opens the page in a browser as a person would: every scene, a desk's size and a phone's, light and
// dark. Fails where nothing is drawn or anything is complained about.
import { spawn } from "node:child_process";
import fs from "node:fs";
import os from "node:os";
import path from "node:path";

const [, , url, shots] = process.argv;
const profile = fs.mkdtempSync(path.join(os.tmpdir(), "page-"));
const name = ["chromium", "chromium-browser", "google-chrome"].find((one) =>
  process.env.PATH.split(":").some((folder) => fs.existsSync(path.join(folder, one))));
const browser = spawn(name, [
  "--headless=new", "--no-sandbox", "--disable-gpu", `--user-data-dir=${profile}`,
  "--remote-debugging-port=0", "about:blank",
], { stdio: ["ignore", "ignore", "pipe"] });
const sleep = (ms) => new Promise((done) => setTimeout(done, ms));
const port = await new Promise((done) => {
  let said = "";
  browser.stderr.on("data", (text) => {
    said += text;
    const found = /ws:\/\/127\.0\.0\.1:(\d+)\//.exec(said);
    if (found) done(found[1]);
  });
});
const pages = await (await fetch(`http://127.0.0.1:${port}/json`)).json();
const socket = new WebSocket(pages.find(({ type }) => type === "page").webSocketDebuggerUrl);
await new Promise((done) => (socket.onopen = done));
const waiting = new Map();
const complaints = [];
socket.onmessage = ({ data }) => {
  const { id, result, method, params } = JSON.parse(data);
  if (id) waiting.get(id)(result);
  if (method === "Runtime.exceptionThrown") complaints.push(JSON.stringify(params.exceptionDetails));
  if (method === "Runtime.consoleAPICalled") complaints.push(JSON.stringify(params.args));
  if (method === "Log.entryAdded") complaints.push(`${params.entry.text} ${params.entry.url}`);
};
let count = 0;
const send = (method, params = {}) => new Promise((done) => {
  waiting.set(++count, done);
  socket.send(JSON.stringify({ id: count, method, params }));
});
const value = async (expression) => (await send("Runtime.evaluate", { expression })).result.value;
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
// How many colours the walls have.
const COLOURS = `new Set([...document.querySelectorAll("#room canvas")].flatMap((one) =>
  [...new Uint32Array(one.getContext("2d").getImageData(0, 0, one.width, one.height).data.buffer)])).size`;

for (const method of ["Runtime", "Log", "Page"]) await send(`${method}.enable`);
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
socket.close();
browser.kill();
if (complaints.length > 0) throw new Error(complaints.join("\n"));
process.exit(0);
