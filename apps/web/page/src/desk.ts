// Questions to a module, one after the other.

export class Trouble extends Error {}

/** The module has stopped, and holds nothing any more. */
export class Stopped extends Trouble {}

export interface Answered<T> {
  words: T;
  bytes: Uint8Array<ArrayBuffer>;
  /** How long the module took, ms. */
  took: number;
}

interface Asked {
  words: string;
  bytes: Uint8Array;
}

interface Said extends Answered<string> {
  id: number;
  /** Why there is no answer, and never will be one. */
  missing?: string;
  stopped?: string;
}

type Waiting = { done: (said: Said) => void; failed: (error: Error) => void };

export class Desk {
  private worker: Worker | null = null;
  private waiting = new Map<number, Waiting>();
  private last = 0;
  /** The picture and the glass, which a module that was started anew is given first. */
  private kept: Asked[] = [];

  /** The module that breaks glass, or that of detectors. */
  constructor(private of: "glass" | "detector") {}

  private open(): Worker {
    const worker = new Worker(new URL("./worker.ts", import.meta.url), { type: "module", name: this.of });
    const stop = (why: string) => {
      if (worker === this.worker) this.close(new Stopped(why));
    };
    const lacks = (what: string) => stop(`a part of the page could not be loaded (${what}); reload the page when there is a network`);
    worker.onmessage = ({ data }: MessageEvent<Said>) => {
      if (data.missing !== undefined) return lacks(data.missing);
      if (data.stopped !== undefined) {
        const wayOut = this.of === "glass" ? "try something smaller" : "run this model by the command, or export it smaller";
        return stop(`the module stopped (${data.stopped}); ${wayOut}`);
      }
      this.waiting.get(data.id)?.done(data);
      this.waiting.delete(data.id);
    };
    worker.onerror = (event) => lacks(event.message || "its script");
    this.kept.forEach((asked) => worker.postMessage({ id: 0, ...asked }));
    return worker;
  }

  /** Ends the module, and all that is asked of it. The next question starts another. */
  close(why: Error = new Stopped("it was closed")) {
    this.worker?.terminate();
    this.worker = null;
    const waiting = [...this.waiting.values()];
    this.waiting.clear();
    waiting.forEach((one) => one.failed(why));
  }

  /** Bytes are copied, never taken away. */
  async ask<T>(question: Record<string, unknown>, bytes = new Uint8Array()): Promise<Answered<T>> {
    const id = ++this.last;
    const asked = { words: JSON.stringify(question), bytes };
    const worker = (this.worker ??= this.open());
    const said = await new Promise<Said>((done, failed) => {
      this.waiting.set(id, { done, failed });
      worker.postMessage({ id, ...asked });
    });
    const words = JSON.parse(said.words) as { answer: T; trouble?: string };
    if (words.trouble !== undefined) throw new Trouble(words.trouble);
    if (question.ask === "street" || question.ask === "picture") this.kept = [asked];
    if (question.ask === "break" && question.is_draft === false) this.kept = [...this.kept.slice(0, 1), asked];
    return { words: words.answer, bytes: said.bytes, took: said.took };
  }
}
