/// <reference lib="webworker" />
// Keeps the page's own files, so that it opens without a network after the first visit.

declare const __FILES__: string[];
declare const __VERSION__: string;
const files: string[] = __FILES__;
const worker = self as unknown as ServiceWorkerGlobalScope;
const shelf = `starbreak ${__VERSION__}`;

worker.addEventListener("install", (event) => {
  event.waitUntil(
    caches
      .open(shelf)
      .then((kept) => kept.addAll(files.map((file) => new Request(file, { cache: "reload" }))))
      .then(() => worker.skipWaiting()),
  );
});

worker.addEventListener("activate", (event) => {
  const old = caches.keys().then((names) =>
    Promise.all(names.filter((name) => name !== shelf && name.startsWith("starbreak ")).map((name) => caches.delete(name))),
  );
  event.waitUntil(old.then(() => worker.clients.claim()));
});

worker.addEventListener("fetch", (event) => {
  const answer = async () => {
    const kept = await caches.open(shelf);
    const found = await kept.match(event.request, { ignoreSearch: true });
    if (found) return found;
    const given = await fetch(event.request);
    // What not everybody needs is kept once it was needed.
    if (event.request.method === "GET" && given.ok && given.type === "basic") await kept.put(event.request, given.clone());
    return given;
  };
  event.respondWith(answer());
});
