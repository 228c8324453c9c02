// What a detector of the user's own sees, before the glass broke and after. It comes with a module of its own,
// which is loaded with the first model.

import { useEffect, useRef, useState } from "preact/hooks";
import type { Box, Found, Model } from "./answers";
import { Desk } from "./desk";
import type { Pixels } from "./stage";

export interface Boxes {
  clean: Box[];
  damaged: Box[];
}

interface Props {
  /** The model, as a file. */
  file: File | null;
  clean: Pixels | null;
  /** The picture behind the glass as it ends; null while it is not known. */
  damaged: Pixels | null;
  onFile(file: File | null): void;
  onBoxes(boxes: Boxes | null): void;
  onFailure(error: unknown): void;
}

/** What was found, and in which pixels. */
interface Seen extends Found {
  pixels: Pixels;
  took: number;
}

export function Detector({ file, clean, damaged, onFile, onBoxes, onFailure }: Props) {
  const desk = useRef<Desk | null>(null);
  const [model, setModel] = useState<Model | null>(null);
  const [inClean, setInClean] = useState<Seen | null>(null);
  const [inDamaged, setInDamaged] = useState<Seen | null>(null);
  const [least, setLeast] = useState(0.3);
  const fails = (error: unknown) => {
    onFailure(error);
    onFile(null);
  };

  useEffect(() => {
    setModel(null);
    if (file === null) return;
    let isStale = false;
    const load = async () => {
      const bytes = new Uint8Array(await file.arrayBuffer());
      const given = await (desk.current ??= new Desk("detector")).ask<Model>({ ask: "model", name: file.name }, bytes);
      if (!isStale) setModel(given.words);
    };
    load().catch((error) => {
      if (!isStale) fails(error);
    });
    return () => {
      isStale = true;
    };
  }, [file]);
  // One picture at a time; of those that come meanwhile, the last of each side.
  const wanted = useRef<{ clean: Pixels | null; damaged: Pixels | null }>({ clean: null, damaged: null });
  const looks = useRef(false);
  useEffect(() => {
    if (model === null) {
      wanted.current = { clean: null, damaged: null };
      setInClean(null);
      setInDamaged(null);
      return;
    }
    if (clean && clean !== inClean?.pixels) wanted.current.clean = clean;
    if (damaged && damaged !== inDamaged?.pixels) wanted.current.damaged = damaged;
    const look = async () => {
      const find = async (pixels: Pixels): Promise<Seen> => {
        const words = { ask: "detect", width_px: pixels.width, height_px: pixels.height };
        const given = await desk.current!.ask<Found>(words, pixels.bytes);
        return { ...given.words, pixels, took: given.took };
      };
      while (wanted.current.clean ?? wanted.current.damaged) {
        const { clean, damaged } = wanted.current;
        wanted.current = { clean: null, damaged: null };
        if (clean) setInClean(await find(clean));
        if (damaged) setInDamaged(await find(damaged));
      }
    };
    if (looks.current) return;
    looks.current = true;
    look()
      .catch(fails)
      .finally(() => {
        looks.current = false;
      });
  }, [model, clean, damaged]);

  const sure = (seen: Seen | null, of: Pixels | null) => (seen && seen.pixels === of ? seen.boxes.filter((box) => box.score >= least) : null);
  const before = sure(inClean, clean);
  const after = sure(inDamaged, damaged);
  useEffect(() => onBoxes(model ? { clean: before ?? [], damaged: after ?? [] } : null), [model, inClean, inDamaged, clean, damaged, least]);

  const classes = [...new Set([...(before ?? []), ...(after ?? [])].map((box) => box.class ?? "?"))].sort();
  const count = (boxes: Box[] | null, name?: string) =>
    boxes === null ? "…" : boxes.filter((box) => name === undefined || (box.class ?? "?") === name).length;
  return (
    <>
      <h2>What a detector sees</h2>
      <div class="buttons">
        <label class="button">
          Open a model
          <input
            type="file"
            class="hidden"
            accept=".onnx"
            onChange={(event) => {
              const file = event.currentTarget.files?.[0];
              if (file) onFile(file);
              event.currentTarget.value = "";
            }}
          />
        </label>
        {file && (
          <button type="button" onClick={() => onFile(null)}>
            Remove it
          </button>
        )}
      </div>
      {file === null ? (
        <p class="about">An ONNX file of yours. It stays in your browser, too.</p>
      ) : (
        <p class="about" title={model?.reason}>
          {model ? `${model.name}, read as ${model.contract}` : `loading ${file.name} …`}
        </p>
      )}
      {model && (
        <>
          <div class="field wide">
            <label for="least">Score from {least.toFixed(2)}</label>
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
          <table class="found" aria-busy={after === null}>
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
          <p class="about">
            Dashed: seen in the clean picture.{inDamaged && ` Found in ${Math.round(inDamaged.took)} ms.`}
          </p>
        </>
      )}
    </>
  );
}
