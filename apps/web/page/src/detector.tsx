// What a detector of the user's own sees, before the glass broke and after. It comes with a module of its own,
// which is loaded with the first model.

import { useEffect, useLayoutEffect, useRef, useState } from "preact/hooks";
import type { Box, Found, Model } from "./answers";
import { Desk, Stopped } from "./desk";
import { FileButton } from "./file_button";
import type { Pixels } from "./stage";

/** What was found in the clean picture and in the damaged one; null while it is not known. */
export interface Boxes {
  clean: Box[] | null;
  damaged: Box[] | null;
}

interface Props {
  /** A model that somebody gave, as a file. */
  file: File | null;
  clean: Pixels | null;
  /** The picture behind the glass as it ends; null while it is not known. */
  damaged: Pixels | null;
  /** Pictures that move are not looked at. */
  isLive: boolean;
  onBoxes(boxes: Boxes | null): void;
  onDone(): void;
  onFailure(error: unknown): void;
}

type Loaded = Model & { desk: Desk };

/** What a model found in which pixels. */
interface Seen extends Found {
  model: Loaded;
  pixels: Pixels;
  took: number;
}

const SIDES = ["clean", "damaged"] as const;
type Side = (typeof SIDES)[number];

export function Detector({ file, clean, damaged, isLive, onBoxes, onDone, onFailure }: Props) {
  const [model, setModel] = useState<Loaded | null>(null);
  const [loading, setLoading] = useState<string | null>(null);
  const [seen, setSeen] = useState<Record<Side, Seen | null>>({ clean: null, damaged: null });
  const [least, setLeast] = useState(0.3);
  // As they are now, for what was begun before.
  const now = useRef({ model, clean, damaged });
  now.current = { model, clean, damaged };
  const done = useRef(seen);

  const change = (next: Loaded | null) => {
    now.current.model?.desk.close();
    now.current.model = next;
    setModel(next);
  };
  const wanted = useRef<File | null>(null);
  const load = async (file: File) => {
    wanted.current = file;
    setLoading(file.name);
    const desk = new Desk("detector");
    try {
      const bytes = new Uint8Array(await file.arrayBuffer());
      const given = await desk.ask<Model>({ ask: "model", name: file.name }, bytes);
      if (wanted.current === file) {
        onDone();
        return change({ ...given.words, desk });
      }
      desk.close();
    } catch (error) {
      desk.close();
      // The model before stays.
      if (wanted.current === file) onFailure(error);
    } finally {
      if (wanted.current === file) setLoading(null);
    }
  };
  useEffect(() => {
    if (file) void load(file);
  }, [file]);

  // One picture at a time, and always those that are there now.
  const looks = useRef(false);
  const look = async () => {
    if (looks.current) return;
    looks.current = true;
    for (;;) {
      const { model, ...pictures } = now.current;
      const isNew = (side: Side) => pictures[side] && (done.current[side]?.model !== model || done.current[side]?.pixels !== pictures[side]);
      const side = SIDES.find(isNew);
      if (!model || !side) break;
      const pixels = pictures[side]!;
      let found: Found & { took: number } = { boxes: [], took: 0 };
      try {
        const words = { ask: "detect", width_px: pixels.width, height_px: pixels.height };
        const given = await model.desk.ask<Found>(words, pixels.bytes);
        found = { ...given.words, took: given.took };
      } catch (error) {
        // Another model, or none, has taken its place.
        if (now.current.model !== model) continue;
        onFailure(error);
        if (error instanceof Stopped) change(null);
      }
      done.current = { ...done.current, [side]: { ...found, model, pixels } };
      setSeen(done.current);
    }
    looks.current = false;
  };
  useEffect(() => void look(), [model, clean, damaged]);

  const sure = (side: Side, of: Pixels | null) => {
    const one = seen[side];
    return model && one && one.model === model && one.pixels === of ? one.boxes.filter((box) => box.score >= least) : null;
  };
  const before = sure("clean", clean);
  const after = sure("damaged", damaged);
  useLayoutEffect(() => onBoxes(model ? { clean: before, damaged: after } : null), [model, seen, clean, damaged, least]);

  const classes = [...new Set([...(before ?? []), ...(after ?? [])].map((box) => box.class ?? "?"))].sort();
  const count = (boxes: Box[] | null, name?: string) =>
    boxes === null ? "…" : boxes.filter((box) => name === undefined || (box.class ?? "?") === name).length;
  const isDone = before !== null && after !== null;
  let words = "An ONNX file of yours. It stays in your browser, too.";
  if (loading !== null) words = `loading ${loading} …`;
  else if (model && isLive) words = `${model.name} looks at pictures, not at the webcam.`;
  else if (model && !isDone) words = `${model.name} looks …`;
  else if (model) words = `${model.name}, read as ${model.contract}: ${model.reason}. Found in ${Math.round(seen.damaged?.took ?? 0)} ms.`;
  return (
    <>
      <h2>What a detector sees</h2>
      <div class="buttons">
        <FileButton words="Open a model" accept=".onnx" onFile={(file) => void load(file)} />
        {(model ?? loading) && (
          <button
            type="button"
            onClick={() => {
              wanted.current = null;
              setLoading(null);
              change(null);
            }}
          >
            Remove the model
          </button>
        )}
      </div>
      <p class="about" role="status">
        {words}
      </p>
      {model && !isLive && (
        <>
          <div class="field wide">
            <label for="least">Score ≥ {least.toFixed(2)}</label>
            <input
              id="least"
              type="range"
              min="0.05"
              max="0.95"
              step="0.05"
              value={least}
              onInput={(event) => setLeast(Number(event.currentTarget.value))}
            />
          </div>
          <table class="found" aria-busy={!isDone}>
            <thead>
              <tr>
                <th scope="col">boxes</th>
                <th scope="col">clean</th>
                <th scope="col">damaged</th>
              </tr>
            </thead>
            <tbody>
              {classes.map((name) => (
                <tr key={name}>
                  <th scope="row">{name}</th>
                  <td>{count(before, name)}</td>
                  <td>{count(after, name)}</td>
                </tr>
              ))}
              <tr>
                <th scope="row">all</th>
                <td>{count(before)}</td>
                <td>{count(after)}</td>
              </tr>
            </tbody>
          </table>
          <p class="about">Dashed in the damaged picture: seen in the clean one.</p>
        </>
      )}
    </>
  );
}
