// A browser without a window, driven by its own protocol (CDP).
import { spawn } from "node:child_process";
import fs from "node:fs";
import http from "node:http";
import os from "node:os";
import path from "node:path";

/// Serves files to this machine: {url, close}. `find` names the file of a path, which comes in parts.
export async function serve(find) {
  const types = { ".js": "text/javascript", ".html": "text/html", ".css": "text/css" };
  const server = http.createServer(({ url }, answer) => {
    const file = find(...url.slice(1).split("/"));
    if (!fs.existsSync(file)) return answer.writeHead(404).end();
    answer.writeHead(200, { "content-type": types[path.extname(file)] ?? "application/octet-stream" });
    answer.end(fs.readFileSync(file));
  });
  await new Promise((done) => server.listen(0, "127.0.0.1", done));
  return { url: `http://127.0.0.1:${server.address().port}`, close: () => server.close() };
}

/// Starts it: {send, value, complaints, close}. `value` evaluates an expression, or what it promises.
export async function openBrowser() {
  const profile = fs.mkdtempSync(path.join(os.tmpdir(), "page-"));
  const name = ["chromium", "chromium-browser", "google-chrome"].find((one) =>
    process.env.PATH.split(":").some((folder) => fs.existsSync(path.join(folder, one))));
  const browser = spawn(name, [
    "--headless=new", "--no-sandbox", "--disable-gpu", `--user-data-dir=${profile}`,
    "--remote-debugging-port=0", "about:blank",
  ], { stdio: ["ignore", "ignore", "pipe"] });
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
  const value = async (expression) => {
    const found = await send("Runtime.evaluate", { expression, awaitPromise: true, returnByValue: true });
    // There is none while another page is loaded.
    const { result, exceptionDetails } = found ?? {};
    if (exceptionDetails) throw new Error(exceptionDetails.exception?.description ?? exceptionDetails.text);
    return result?.value;
  };
  const close = () => {
    socket.close();
    browser.kill();
  };
  for (const method of ["Runtime", "Log", "Page"]) await send(`${method}.enable`);
  return { send, value, complaints, close };
}
