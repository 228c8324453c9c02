// What can be taken away: the link, the command, the line of Python, and files.

import { useState } from "preact/hooks";
import type { Broken } from "./answers";
import type { Desk } from "./desk";
import { toCommand, toPython, type State } from "./state";

const FILES: [string, string][] = [
  ["picture", "Picture"],
  ["clean", "Clean picture"],
  ["region", "Region mask"],
  ["crack", "Crack mask"],
  ["network.json", "Network"],
  ["network.svg", "Drawing"],
  ["recipe", "Recipe"],
];

const CRACK_FILES = ["crack", "network.json", "network.svg"];

interface Props {
  desk: Desk;
  state: State;
  /** File name of the picture. */
  name: string;
  broken: Broken | null;
  isBusy: boolean;
  /** Whether the page shows the cracks on their way. */
  isGrowing: boolean;
  onFailure(error: unknown): void;
}

export function Away({ desk, state, name, broken, isBusy, isGrowing, onFailure }: Props) {
  const [said, setSaid] = useState("");
  const save = async (what: string) => {
    try {
      const file = await desk.ask<{ name: string; media_type: string }>({ ask: "file", what });
      const link = document.createElement("a");
      link.href = URL.createObjectURL(new Blob([file.bytes], { type: file.words.media_type }));
      link.download = file.words.name;
      link.click();
      setSaid(`${file.words.name} saved${isGrowing && what !== "clean" ? ", with the cracks as they end" : ""}`);
      setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
    } catch (error) {
      onFailure(error);
    }
  };
  const copy = async (text: string, what: string) => {
    try {
      await navigator.clipboard.writeText(text);
      setSaid(`Copied: ${what}`);
    } catch {
      setSaid(text);
    }
  };
  const needs = state.hits.length > 1 ? " (it reads the recipe of several hits: download that, too)" : "";
  const isReady = broken !== null && !isBusy;
  const lines = [
    ["Command", toCommand],
    ["Python", toPython],
  ] as const;
  return (
    <>
      <h2>Take away</h2>
      <div class="buttons">
        <button type="button" onClick={() => void copy(location.href, "Link")}>
          Copy link
        </button>
        {lines.map(([what, line]) => (
          <button
            type="button"
            disabled={!isReady}
            onClick={() => void copy(line(state, broken?.assignments ?? [], name), what + needs)}
          >
            Copy {what === "Python" ? what : what.toLowerCase()}
          </button>
        ))}
      </div>
      <h2 id="download">Download</h2>
      <div class="buttons" role="group" aria-labelledby="download">
        {FILES.map(([what, word]) => (
          <button type="button" disabled={!isReady || (CRACK_FILES.includes(what) && !broken.damage)} onClick={() => void save(what)}>
            {word}
          </button>
        ))}
      </div>
      <p class="said" role="status">
        {said}
      </p>
    </>
  );
}
