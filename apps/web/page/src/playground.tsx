// The page: a picture with glass before it, what it is made of, and what can be taken away.

import { useCallback, useEffect, useMemo, useRef, useState } from "preact/hooks";
import type { Broken, Catalog, Grown, Picture } from "./answers";
import { Away } from "./away";
import { Desk, Trouble } from "./desk";
import { Detector, type Boxes } from "./detector";
import { FileButton } from "./file_button";
import { Figures, timeWords } from "./figures";
import { Panel } from "./panel";
import { Presets } from "./presets";
import { Stage, type Look, type Pixels } from "./stage";
import { fromAddress, question, toAddress, type Hit, type State } from "./state";
import { Webcam } from "./webcam";

const LOOKS: [Look, string][] = [
  ["damaged", "Damaged"],
  ["swipe", "Before | after"],
  ["clean", "Clean"],
  ["region", "Region mask"],
  ["crack", "Crack mask"],
  ["arrival", "Cracks by time"],
  ["stress", "Cracks by stress"],
  ["depth", "Cracks by depth"],
];
const CRACK_LOOKS: Look[] = ["crack", "arrival", "stress", "depth"];
/** How long the growth is shown, ms. */
const GROWTH_MS = 2500;
const START: State = { preset: "windshield-spiderweb", severity: 3, camera: null, set: {}, hits: [], seed: 1 };

export function Playground() {
  const desk = useMemo(() => new Desk("glass"), []);
  const [address] = useState(() => fromAddress(location.hash, START));
  const [catalog, setCatalog] = useState<Catalog | null>(null);
  const [picture, setPicture] = useState<(Picture & Pixels) | null>(null);
  const [state, setState] = useState<State>(address.state);
  const [pending, setPending] = useState<Hit | null>(null);
  const [broken, setBroken] = useState<(Broken & { took: number }) | null>(null);
  const [damaged, setDamaged] = useState<Pixels | null>(null);
  // The damaged picture with the cracks as they end.
  const [whole, setWhole] = useState<Pixels | null>(null);
  // A moment of the webcam.
  const [live, setLive] = useState<{ clean: Pixels; damaged: Pixels } | null>(null);
  const [model, setModel] = useState<File | null>(null);
  const [boxes, setBoxes] = useState<Boxes | null>(null);
  const [look, setLook] = useState<Look>("damaged");
  const [mask, setMask] = useState<ImageBitmap | null>(null);
  const [cracks, setCracks] = useState<Float32Array | null>(null);
  const [trouble, setTrouble] = useState<string | null>(null);
  const [share, setShare] = useState(1);
  const [grown, setGrown] = useState<Grown | null>(null);
  const [plays, setPlays] = useState(false);
  const [isBusy, setIsBusy] = useState(false);
  const [isCamera, setIsCamera] = useState(false);
  const [nShown, setNShown] = useState(0);

  const fails = (error: unknown) => setTrouble(error instanceof Trouble ? error.message : String(error));
  const pixelsOf = (picture: Picture, bytes: Pixels["bytes"]): Picture & Pixels => ({
    ...picture,
    width: picture.width_px,
    height: picture.height_px,
    bytes,
  });

  /** Shows what the module made of the picture that is before the camera now. */
  const showDamaged = (bytes: Pixels["bytes"], isWhole: boolean) =>
    setPicture((picture) => {
      const shown = picture && { width: picture.width, height: picture.height, bytes };
      setDamaged(shown);
      if (isWhole) setWhole(shown);
      return picture;
    });

  const load = useCallback(
    async (name: string | null, bytes?: Pixels["bytes"]) => {
      const given = await desk.ask<Picture>(name === null ? { ask: "street" } : { ask: "picture", name }, bytes);
      hasGlass.current = false;
      setDamaged(null);
      setWhole(null);
      setMask(null);
      setCracks(null);
      setGrown(null);
      setPlays(false);
      setPicture(pixelsOf(given.words, given.bytes));
      setTrouble(null);
    },
    [desk],
  );
  const loadFile = useCallback(
    async (file: File) => {
      if (/\.onnx$/i.test(file.name)) return setModel(file);
      setIsCamera(false);
      try {
        await load(file.name, new Uint8Array(await file.arrayBuffer()));
      } catch (error) {
        fails(error);
      }
    },
    [load],
  );

  useEffect(() => {
    desk.ask<Catalog>({ ask: "catalog" }).then((given) => setCatalog(given.words), fails);
    load(null).catch(fails);
    const follow = () => {
      const { state, left } = fromAddress(location.hash, START);
      leftOut.current = left;
      setState(state);
    };
    addEventListener("hashchange", follow);
    return () => removeEventListener("hashchange", follow);
  }, []);

  // What the address says that means nothing, until it was told.
  const leftOut = useRef(address.left);
  // Whether glass stands before the picture.
  const hasGlass = useRef(false);
  // One break at a time; of those that were asked for meanwhile, the last.
  const wanted = useRef<{ state: State; isDraft: boolean } | null>(null);
  const isBreaking = useRef(false);
  // What was shown last, to which a refused change goes back.
  const good = useRef<State | null>(null);
  const isBack = useRef(false);
  const shatter = useCallback(
    async (state: State, isDraft: boolean) => {
      wanted.current = { state, isDraft };
      if (isBreaking.current) return;
      isBreaking.current = true;
      setIsBusy(true);
      while (wanted.current) {
        const next: { state: State; isDraft: boolean } = wanted.current;
        wanted.current = null;
        try {
          const given = await desk.ask<Broken>(question(next.state, next.isDraft));
          setBroken({ ...given.words, took: given.took });
          if (!next.isDraft) {
            good.current = next.state;
            hasGlass.current = true;
            setNShown((n) => n + 1);
          }
          showDamaged(given.bytes, !next.isDraft);
          const left = leftOut.current.length > 0 ? `of the address is left out: ${leftOut.current.join("; ")}` : null;
          if (!isBack.current) setTrouble(left);
          else if (left) setTrouble((trouble) => `${trouble}; ${left}`);
          if (!next.isDraft) leftOut.current = [];
          isBack.current = false;
          setShare(1);
          setGrown(null);
        } catch (error) {
          fails(error);
          const back = good.current ?? START;
          if (!next.isDraft && next.state !== START && wanted.current === null) {
            isBack.current = true;
            // Where only the picture is another, nothing that could be set is better.
            if (back === next.state) setBroken(null);
            else setState(back);
          }
        }
      }
      isBreaking.current = false;
      setIsBusy(false);
    },
    [desk],
  );

  useEffect(() => {
    if (picture && catalog) void shatter(state, false);
    history.replaceState(null, "", toAddress(state));
  }, [state, picture?.name, picture?.bytes, catalog]);
  useEffect(() => {
    if (pending) void shatter({ ...state, hits: [...state.hits, pending] }, true);
  }, [pending]);

  const canBreak = !broken || broken.recipe.impact !== undefined;
  const hasCracks = broken?.damage != null;
  // What lies over the picture is asked for when it is looked at.
  useEffect(() => {
    let isStale = false;
    const show = async () => {
      if (look === "region" || look === "crack") {
        const file = await desk.ask<{ name: string }>({ ask: "file", what: look });
        const bitmap = await createImageBitmap(new Blob([file.bytes], { type: "image/png" }));
        if (!isStale) setMask(bitmap);
      } else if (look === "arrival" || look === "stress" || look === "depth") {
        const given = await desk.ask({ ask: "cracks" });
        if (!isStale) setCracks(new Float32Array(given.bytes.buffer));
      }
    };
    if (broken && (hasCracks || !CRACK_LOOKS.includes(look))) show().catch(fails);
    return () => {
      isStale = true;
    };
  }, [look, broken]);

  // Growth, frame by frame as fast as they come.
  const growTo = useCallback(
    async (share: number) => {
      setShare(share);
      const given = await desk.ask<Grown>({ ask: "grown", share });
      setGrown(given.words);
      // In the end it is the whole, and not a picture like it.
      if (share === 1) setWhole((whole) => (setDamaged(whole), whole));
      else showDamaged(given.bytes, false);
    },
    [desk],
  );
  useEffect(() => {
    if (!plays) return;
    let isOver = false;
    const play = async () => {
      const start = performance.now();
      while (!isOver) {
        const share = Math.min((performance.now() - start) / GROWTH_MS, 1);
        await growTo(share);
        if (share === 1) break;
      }
      if (!isOver) setPlays(false);
    };
    play().catch((error) => {
      fails(error);
      setPlays(false);
    });
    return () => {
      isOver = true;
    };
  }, [plays]);

  const change = (part: Partial<State>) => setState((now) => ({ ...now, ...part }));
  const name = picture?.name ?? "scene.png";
  useEffect(() => {
    if (broken && !hasCracks && CRACK_LOOKS.includes(look)) setLook("damaged");
  }, [broken]);
  return (
    <div
      class="page"
      data-shown={nShown}
      onDragOver={(event) => event.preventDefault()}
      onDrop={(event) => {
        event.preventDefault();
        const file = event.dataTransfer?.files[0];
        if (file) void loadFile(file);
      }}
      onPaste={(event) => {
        const file = event.clipboardData?.files[0];
        if (file) void loadFile(file);
      }}
    >
      <header>
        <h1>starbreak</h1>
        <p>Click on the picture: a stone hits the glass there. Drag to throw it.</p>
      </header>
      <main>
        <section class="picture" aria-label="Picture">
          <Stage
            clean={live?.clean ?? picture}
            damaged={live?.damaged ?? damaged}
            mask={mask}
            cracks={cracks}
            look={look}
            boxes={boxes && { ...boxes, damaged: damaged === whole ? boxes.damaged : null }}
            hits={canBreak ? state.hits : []}
            label={`${name} behind broken glass. Arrow keys move the aim, Enter throws a stone.`}
            onHit={(hit, isDraft) => {
              if (!canBreak) {
                return setTrouble("here nothing breaks: choose a preset of glass, and add the fault to it");
              }
              if (look !== "damaged") setLook("damaged");
              if (isDraft) return setPending(hit);
              setPending(null);
              setState((now) => ({ ...now, hits: [...now.hits, hit] }));
            }}
            onCancel={() => {
              setPending(null);
              void shatter(state, false);
            }}
          />
          <div class="bar">
            <label>
              View{" "}
              <select
                value={look}
                onChange={(event) => {
                  const next = event.currentTarget.value as Look;
                  setTrouble(null);
                  // Masks are those of the whole.
                  const isMask = next === "region" || next === "crack";
                  if (isMask && broken?.last_arrival != null) growTo(1).catch(fails);
                  setLook(next);
                }}
              >
                {LOOKS.map(([value, word]) => (
                  <option value={value} disabled={!hasCracks && CRACK_LOOKS.includes(value)}>
                    {word}
                  </option>
                ))}
              </select>
            </label>
            <button type="button" disabled={broken?.last_arrival == null} onClick={() => setPlays(!plays)}>
              {plays ? "Stop" : "Play growth"}
            </button>
            <label class="growth">
              <span class="hidden">Growth</span>
              <input
                type="range"
                min="0"
                max="1"
                step="0.01"
                value={share}
                disabled={broken?.last_arrival == null}
                onInput={(event) => {
                  setPlays(false);
                  growTo(Number(event.currentTarget.value)).catch(fails);
                }}
              />
            </label>
            <output class="time">{grown ? timeWords(grown.time, grown.unit) : ""}</output>
            <button type="button" disabled={state.hits.length === 0} onClick={() => change({ hits: state.hits.slice(0, -1) })}>
              Undo hit
            </button>
            <button type="button" disabled={state.hits.length === 0} onClick={() => change({ hits: [] })}>
              Clear hits
            </button>
          </div>
          <p class="trouble" role="alert">
            {trouble}
          </p>
          <Presets presets={catalog?.presets ?? []} chosen={state.preset} isReady={nShown > 0} onChoice={(preset) => change({ preset, set: {} })} />
          {broken && <Figures broken={broken} took={broken.took} isOld={isBusy} />}
        </section>
        <section class="controls" aria-label="Recipe">
          <div class="fields">
            <div class="field wide">
              <label for="severity">Severity {state.severity}</label>
              <input
                id="severity"
                type="range"
                min="1"
                max="5"
                step="1"
                value={state.severity}
                onChange={(event) => change({ severity: Number(event.currentTarget.value) })}
              />
            </div>
            <div class="field wide">
              <label for="camera">Camera</label>
              <select
                id="camera"
                value={state.camera ?? ""}
                onChange={(event) => change({ camera: event.currentTarget.value || null })}
              >
                <option value="">that of the preset</option>
                {catalog?.cameras.map((camera) => (
                  <option value={camera.name} title={camera.about}>
                    {camera.name}
                  </option>
                ))}
              </select>
            </div>
            <div class="field wide">
              <label for="seed">Seed</label>
              <input
                id="seed"
                type="number"
                min="0"
                step="1"
                value={state.seed}
                onChange={(event) => {
                  const text = event.currentTarget.value.trim();
                  const seed = Number(text);
                  if (text !== "" && Number.isSafeInteger(seed) && seed >= 0) return change({ seed });
                  event.currentTarget.value = String(state.seed);
                  setTrouble(`seed = ${text}; expected a whole number from 0 to ${Number.MAX_SAFE_INTEGER}`);
                }}
              />
              <button type="button" onClick={() => change({ seed: crypto.getRandomValues(new Uint16Array(1))[0]! })}>
                Roll
              </button>
            </div>
          </div>
          {catalog && (
            <Panel
              catalog={catalog}
              broken={broken}
              set={state.set}
              onSet={(key, toml) => {
                const { [key]: _, ...others } = state.set;
                change({ set: toml === null ? others : { ...others, [key]: toml } });
              }}
            />
          )}
        </section>
        <section class="away" aria-label="Pictures and files">
          <h2>Your picture</h2>
          <div class="buttons">
            <FileButton
              words="Open a photo"
              accept="image/png,image/jpeg,image/webp,image/bmp"
              onFile={(file) => void loadFile(file)}
            />
            <button
              type="button"
              onClick={() => {
                setIsCamera(false);
                load(null).catch(fails);
              }}
            >
              The street
            </button>
            <button type="button" aria-pressed={isCamera} onClick={() => setIsCamera(!isCamera)}>
              {isCamera ? "Stop webcam" : "Webcam"}
            </button>
          </div>
          <p class="about">It stays in your browser: this page sends nothing.</p>
          <Away
            desk={desk}
            state={state}
            name={name}
            broken={broken}
            isBusy={isBusy}
            isGrowing={share < 1}
            onFailure={fails}
          />
          <Detector
            file={model}
            clean={live ? null : picture}
            damaged={live ? null : whole}
            isLive={live !== null}
            onBoxes={setBoxes}
            onDone={() => setTrouble(null)}
            onFailure={fails}
          />
        </section>
      </main>
      <footer class="about">
        starbreak {catalog?.version} is free under MIT or Apache-2.0; <a href="LICENSE-THIRD-PARTY.txt">what it contains</a>.
      </footer>
      {isCamera && (
        <Webcam
          onPicture={(bytes) => load("webcam.png", bytes)}
          through={async (frame) => {
            if (!hasGlass.current) return null;
            const given = await desk.ask<null>({ ask: "frame", width_px: frame.width, height_px: frame.height }, frame.bytes);
            return { ...frame, bytes: given.bytes };
          }}
          onMoment={(clean, damaged) => setLive({ clean, damaged })}
          onEnd={() => setLive(null)}
          onFailure={(error) => {
            setIsCamera(false);
            fails(error);
          }}
        />
      )}
    </div>
  );
}
