// Questions to a module, one after the other.

export class Trouble extends Error {}

export interface Answered<T> {
  words: T;
  bytes: Uint8Array<ArrayBuffer>;
  /** How long the module took, ms. */
  took: number;
}

interface Said {
  id: number;
  words: string;
  bytes: Uint8Array<ArrayBuffer>;
  took: number;
  stopped?: string;
}

type Waiting = { done: (said: Said) => void; failed: (error: Error) => void };

/** The module that breaks glass, or that of detectors. */
export type Of = "glass" | "detector";

export class Desk {
  private worker: Worker;
  private waiting = new Map<number, Waiting>();
  private last = 0;
  /** What a module that was started anew is given first. */
  private first: { words: string; bytes: Uint8Array } | null = null;

  constructor(private of: Of) {
    this.worker = this.open();
  }

  private open(): Worker {
    const worker = new Worker(new URL("./worker.ts", import.meta.url), { type: "module", name: this.of });
    worker.onmessage = (event: MessageEvent<Said>) => {
      if (event.data.stopped !== undefined) return this.startAnew(event.data.stopped);
      this.waiting.get(event.data.id)?.done(event.data);
      this.waiting.delete(event.data.id);
    };
    worker.onerror = (event) => this.startAnew(event.message || "its script did not load");
    return worker;
  }

  /** A module that has stopped holds nothing that can be trusted: another one takes its place. */
  private startAnew(why: string) {
    this.worker.terminate();
    const stopped = new Trouble(
      this.of === "glass"
        ? `the module stopped (${why}) and was started anew; try something smaller`
        : `the model stopped its module (${why}); run it by the command with ONNX Runtime, or export it smaller`,
    );
    const waiting = [...this.waiting.values()];
    this.waiting.clear();
    this.worker = this.open();
    if (this.first) this.worker.postMessage({ id: 0, ...this.first });
    waiting.forEach((one) => one.failed(stopped));
  }

  /** Bytes are copied, never taken away. */
  async ask<T>(question: Record<string, unknown>, bytes = new Uint8Array()): Promise<Answered<T>> {
    const id = ++this.last;
    const asked = { words: JSON.stringify(question), bytes };
    const said = await new Promise<Said>((done, failed) => {
      this.waiting.set(id, { done, failed });
      this.worker.postMessage({ id, ...asked });
    });
    const words = JSON.parse(said.words) as { answer: T; trouble?: string };
    if (words.trouble !== undefined) throw new Trouble(words.trouble);
    if (question.ask === "street" || question.ask === "picture") this.first = asked;
    return { words: words.answer, bytes: said.bytes, took: said.took };
  }
}
