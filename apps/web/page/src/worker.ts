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

function answer(desk: Desk, words: string, bytes: Uint8Array) {
  const question = new TextEncoder().encode(words);
  const lay = (at: number, bytes: Uint8Array) => new Uint8Array(desk.memory.buffer, at, bytes.length).set(bytes);
  // Each call may move the memory, so it is looked up after it.
  lay(desk.room_for_question(question.length), question);
  lay(desk.room_for_bytes(bytes.length), bytes);
  const length = desk.ask();
  const said = new TextDecoder().decode(new Uint8Array(desk.memory.buffer, desk.words_at(), length));
  const given = new Uint8Array(desk.memory.buffer, desk.bytes_at(), desk.n_bytes()).slice();
  return { words: said, bytes: given };
}

self.onmessage = async (event: MessageEvent<{ id: number; words: string; bytes: Uint8Array }>) => {
  const { id, words, bytes } = event.data;
  try {
    const start = performance.now();
    const given = answer(await desk, words, bytes);
    const took = performance.now() - start;
    self.postMessage({ id, ...given, took }, { transfer: [given.bytes.buffer] });
  } catch (error) {
    // The module has stopped; nothing that it held can be trusted.
    self.postMessage({ id, stopped: String(error) });
  }
};
