/// <reference lib="webworker" />
// Keeps the page's own files, so that it opens without a network after the first visit.

declare const __FILES__: string[];
declare const __VERSION__: string;
const files: string[] = __FILES__;
const worker = self as unknown as ServiceWorkerGlobalScope;
const PREFIX = "starbreak ";
const shelf = `${PREFIX}${__VERSION__}`;

worker.addEventListener("install", (event) => {
  event.waitUntil(
    caches
      .open(shelf)
      .then((kept) => kept.addAll(files.map((file) => new Request(file, { cache: "reload" }))))
      .then(() => worker.skipWaiting()),
  );
});

worker.addEventListener("activate", (event) => {
  // In the order in which they came. A page that is open still needs files of the one before.
  const old = caches.keys().then((names) => {
    const others = names.filter((name) => name !== shelf && name.startsWith(PREFIX));
    return Promise.all(others.slice(0, -1).map((name) => caches.delete(name)));
  });
  event.waitUntil(old.then(() => worker.clients.claim()));
});

worker.addEventListener("fetch", (event) => {
  const answer = async () => {
    const kept = await caches.open(shelf);
    const options = { ignoreSearch: true };
    const found = (await kept.match(event.request, options)) ?? (await caches.match(event.request, options));
    if (found) return found;
    const given = await fetch(event.request);
    // What not everybody needs is kept once it was needed; a name with a hash stands for what is in it.
    if (given.ok && new URL(event.request.url).pathname.includes("/assets/")) {
      event.waitUntil(kept.put(event.request, given.clone()).catch(() => {}));
    }
    return given;
  };
  event.respondWith(answer());
});
