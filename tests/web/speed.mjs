// Prints the frames a second of the page, of scene A, foveated, on three walls of 512², while the gaze
// goes around on them.
//
//   node --experimental-websocket tests/web/speed.mjs PAGE   the folder that host/web/build makes
import path from "node:path";
import { openBrowser, serve } from "./browser.mjs";

const server = await serve((...parts) => path.join(process.argv[2], ...parts));
const { send, value, close } = await openBrowser();
const sleep = (ms) => new Promise((done) => setTimeout(done, ms));
const frames = () => value("Number(document.body?.dataset.frames ?? 0)");
await send("Emulation.setDeviceMetricsOverride", { width: 1280, height: 900, deviceScaleFactor: 1, mobile: false });
await send("Page.navigate", { url: `${server.url}/index.html#scene=animal&size=512&detail=foveated` });
while (!((await frames()) > 0)) await sleep(50);
await value(`void setInterval(() => {
  const [x, y] = [Math.cos, Math.sin].map((of) => 250 + 100 * of(performance.now() / 500));
  document.getElementById("stage").dispatchEvent(new PointerEvent("pointermove", { clientX: x, clientY: y }));
}, 16)`);
// Until the browser has compiled what it runs.
await sleep(3000);
const [begun, before] = [performance.now(), await frames()];
await sleep(10000);
const rate = 1000 * ((await frames()) - before) / (performance.now() - begun);
console.log(`${rate.toFixed(1)} frames a second on ${await value("document.getElementById('notes').textContent")}`);
close();
process.exit(0);
