// The built page over HTTP on this machine, as any web server gives it.

import { createServer } from "node:http";
import { readFile } from "node:fs/promises";
import { extname, join, normalize } from "node:path";

const TYPES = {
  ".html": "text/html; charset=utf-8",
  ".js": "text/javascript",
  ".css": "text/css",
  ".svg": "image/svg+xml",
  ".wasm": "application/wasm",
};

/** Serves a folder; gives the server, which listens. */
export async function serve(folder, port = 0) {
  const server = createServer(async (request, response) => {
    const path = normalize(decodeURIComponent(new URL(request.url, "http://x").pathname));
    const file = join(folder, path.endsWith("/") ? path + "index.html" : path);
    try {
      const bytes = await readFile(file);
      response.writeHead(200, { "content-type": TYPES[extname(file)] ?? "application/octet-stream" });
      response.end(bytes);
    } catch {
      response.writeHead(404);
      response.end("not here");
    }
  });
  await new Promise((done, failed) => server.on("error", failed).listen(port, "127.0.0.1", done));
  return server;
}

if (import.meta.filename === process.argv[1]) {
  const server = await serve(process.argv[2], 8000).catch(() => serve(process.argv[2]));
  console.log(`http://127.0.0.1:${server.address().port}/`);
}
