// Questions to the module, one after the other.

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

export class Desk {
  private worker = this.open();
  private waiting = new Map<number, Waiting>();
  private last = 0;

  private open(): Worker {
    const worker = new Worker(new URL("./worker.ts", import.meta.url), { type: "module" });
    worker.onmessage = (event: MessageEvent<Said>) => {
      const waiting = this.waiting.get(event.data.id);
      this.waiting.delete(event.data.id);
      if (event.data.stopped === undefined) {
        waiting?.done(event.data);
        return;
      }
      const stopped = new Trouble(`the module stopped (${event.data.stopped}); reload the page, and try something smaller`);
      waiting?.failed(stopped);
      this.waiting.forEach((other) => other.failed(stopped));
      this.waiting.clear();
      this.worker.terminate();
      this.worker = this.open();
    };
    return worker;
  }

  async ask<T>(question: Record<string, unknown>, bytes = new Uint8Array()): Promise<Answered<T>> {
    const id = ++this.last;
    const said = await new Promise<Said>((done, failed) => {
      this.waiting.set(id, { done, failed });
      this.worker.postMessage({ id, words: JSON.stringify(question), bytes });
    });
    const words = JSON.parse(said.words) as { answer: T; trouble?: string };
    if (words.trouble !== undefined) throw new Trouble(words.trouble);
    return { words: words.answer, bytes: said.bytes, took: said.took };
  }
}
