/// <reference lib="webworker" />
// A module in Rust, off the page's own thread: words and bytes in, words and bytes out. The name of the worker says
// which.

import detector from "detector.wasm?url";
import glass from "glass.wasm?url";

interface Desk {
  memory: WebAssembly.Memory;
  take_seat(): void;
  room_for_question(nBytes: number): number;
  room_for_bytes(nBytes: number): number;
  ask(): number;
  words_at(): number;
  bytes_at(): number;
  n_bytes(): number;
}

const desk = WebAssembly.instantiateStreaming(fetch(self.name === "detector" ? detector : glass), {}).then((module) => {
  const desk = module.instance.exports as unknown as Desk;
  desk.take_seat();
  return desk;
});
// Whoever asks hears of it.
desk.catch(() => {});

function answer(desk: Desk, words: string, bytes: Uint8Array) {
  const question = new TextEncoder().encode(words);
  // Numbers of the module are signed here: half of its memory would lie below 0.
  const part = (at: number, length: number) => new Uint8Array(desk.memory.buffer, at >>> 0, length >>> 0);
  // Each call may move the memory, so it is looked up after it.
  const lay = (at: number, bytes: Uint8Array) => part(at, bytes.length).set(bytes);
  lay(desk.room_for_question(question.length), question);
  lay(desk.room_for_bytes(bytes.length), bytes);
  const length = desk.ask();
  const said = new TextDecoder().decode(part(desk.words_at(), length));
  const given = part(desk.bytes_at(), desk.n_bytes()).slice();
  return { words: said, bytes: given };
}

let hasStopped = false;

self.onmessage = async (event: MessageEvent<{ id: number; words: string; bytes: Uint8Array }>) => {
  const { id, words, bytes } = event.data;
  let seated: Desk;
  try {
    seated = await desk;
  } catch (error) {
    self.postMessage({ id, missing: String(error) });
    return;
  }
  if (hasStopped) return;
  try {
    const start = performance.now();
    const given = answer(seated, words, bytes);
    const took = performance.now() - start;
    self.postMessage({ id, ...given, took }, { transfer: [given.bytes.buffer] });
  } catch (error) {
    // Nothing that the module held can be trusted.
    hasStopped = true;
    self.postMessage({ id, stopped: String(error) });
  }
};
