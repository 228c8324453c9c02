// The presets, each with a small picture of its glass: those that the tests keep.

import type { Named } from "./answers";

const FOLDER = "../../../../tests/golden/pictures";
const pictures = import.meta.glob<string>("../../../../tests/golden/pictures/*.png", {
  eager: true,
  query: "?url",
  import: "default",
});

const pictureOf = (name: string) => pictures[`${FOLDER}/${name}-glass.png`] ?? pictures[`${FOLDER}/${name}-scene.png`];

interface Props {
  presets: Named[];
  chosen: string;
  /** Whether the first picture is there, which these must not delay. */
  isReady: boolean;
  onChoice(preset: string): void;
}

export function Presets({ presets, chosen, isReady, onChoice }: Props) {
  return (
    <fieldset class="presets">
      <legend class="hidden">Preset</legend>
      {presets.map(({ name, about }) => (
        <label key={name} title={about}>
          <input
            type="radio"
            name="preset"
            class="hidden"
            value={name}
            checked={name === chosen}
            onChange={() => onChoice(name)}
          />
          <span class="thumbnail">{isReady && <img src={pictureOf(name)} alt="" />}</span>
          <span>{name.replaceAll("-", " ")}</span>
        </label>
      ))}
      <p class="about">{presets.find(({ name }) => name === chosen)?.about}</p>
    </fieldset>
  );
}
