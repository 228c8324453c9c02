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
  event.respondWith(caches.match(event.request, { ignoreSearch: true }).then((kept) => kept ?? fetch(event.request)));
});
