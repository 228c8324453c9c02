// The keys of the recipe, made from its schema.

import type { Broken, Catalog, Key, Table } from "./answers";

/** What most people turn, in the order of the light's way. */
const BASIC: [string, string][] = [
  ["impact", "speed_m_s"],
  ["impact", "radius_mm"],
  ["impact", "tip_radius_mm"],
  ["glass", "distance_m"],
  ["glass", "rake_deg"],
  ["camera", "focal_length_mm"],
  ["camera", "f_number"],
  ["camera", "focus_distance_m"],
  ["optics", "sun_azimuth_deg"],
  ["optics", "sun_elevation_deg"],
  ["optics", "veiling_glare"],
  ["exposure", "ev"],
  ["banding", "depth"],
  ["banding", "mains_hz"],
  ["banding", "row_us"],
  ["banding", "led_duty"],
  ["spots", "count"],
  ["spots", "size_um"],
  ["cfa", "loss"],
  ["noise", "white_e"],
  ["noise", "read_e"],
  ["noise", "row_e"],
  ["pixels", "dead_per_mpx"],
  ["pixels", "hot_per_mpx"],
  ["pixels", "stuck_per_mpx"],
  ["lines", "rows"],
  ["lines", "columns"],
  ["mosaic", "share"],
  ["isp", "black_level_percent"],
  ["isp", "white_balance"],
  ["isp", "color_matrix"],
  ["isp", "unsharp"],
  ["isp", "tone"],
  ["link", "bit_error_rate"],
  ["link", "jpeg_quality"],
  ["link", "row_bits"],
  ["frames", "black"],
  ["frames", "white"],
  ["sensor", "number"],
];
/** What is set to add a fault: its key, and the value of its preset unless there is one here. */
const ADDED: [string, string, number?][] = [
  ["exposure", "ev", -2],
  ["banding", "depth"],
  ["spots", "count"],
  ["cfa", "loss"],
  ["noise", "white_e"],
  ["pixels", "hot_per_mpx"],
  ["lines", "rows"],
  ["mosaic", "share"],
  ["isp", "unsharp"],
  ["link", "bit_error_rate", 1e-4],
  ["frames", "black", 0.5],
  ["sensor", "number", 1],
];
const TITLES: Record<string, string> = {
  impact: "Stone",
  glass: "Glass",
  fracture: "Fracture",
  long_crack: "Long crack",
  camera: "Camera",
  optics: "Light",
  exposure: "Exposure",
  banding: "Lamps",
  noise: "Noise",
  pixels: "Defective pixels",
  lines: "Defective lines",
  spots: "Dust on the sensor",
  cfa: "Color filters",
  mosaic: "Demosaicing",
  isp: "Image processor",
  link: "Link",
  frames: "Frames",
  sensor: "Sensor",
};
/** Set by buttons of their own, or of no use on a page. */
const HIDDEN = ["impact.position", "impact.count"];

interface Props {
  catalog: Catalog;
  broken: Broken | null;
  set: Record<string, string>;
  onSet(key: string, toml: string | null): void;
}

export function Panel({ catalog, broken, set, onSet }: Props) {
  if (!broken) return null;
  const tableOf = (name: string): Table | undefined => {
    const table = broken.recipe[name];
    return Array.isArray(table) ? table[0] : table;
  };
  const field = (place: string, table: string, key: string) => {
    const value = tableOf(table)?.[key];
    const keys = catalog.schema.properties[table];
    const about = (keys?.items?.properties ?? keys?.properties)?.[key];
    if (value === undefined || !about) return null;
    const name = `${table}.${key}`;
    return <Field key={name} id={`${place}-${name}`} name={name} about={about} value={value} isSet={name in set} onSet={(toml) => onSet(name, toml)} />;
  };
  const tables = Object.keys(TITLES).filter((name) => tableOf(name) !== undefined);
  return (
    <>
      {[...new Set(BASIC.map(([table]) => table))].map((title) => {
        const fields = BASIC.map(([table, key]) => table === title && field("basic", table, key)).filter(Boolean);
        return (
          fields.length > 0 && (
            <fieldset key={title}>
              <legend>{TITLES[title]}</legend>
              <div class="fields">{fields}</div>
            </fieldset>
          )
        );
      })}
      <fieldset>
        <legend>Add</legend>
        <div class="buttons">
          {ADDED.filter(([table]) => tableOf(table) === undefined).map(([table, key, value]) => (
            <button type="button" key={table} onClick={() => onSet(`${table}.${key}`, String(value ?? catalog.faults[table]?.[key]))}>
              {TITLES[table]}
            </button>
          ))}
        </div>
      </fieldset>
      <details>
        <summary>All parameters</summary>
        {tables.map((table) => (
          <fieldset key={table}>
            <legend>{TITLES[table]}</legend>
            <div class="fields">
              {Object.keys(tableOf(table)!)
                .filter((key) => !HIDDEN.includes(`${table}.${key}`))
                .map((key) => field("all", table, key))}
            </div>
          </fieldset>
        ))}
      </details>
    </>
  );
}

interface FieldProps {
  id: string;
  name: string;
  about: Key;
  value: unknown;
  isSet: boolean;
  onSet(toml: string | null): void;
}

function Field({ id, name, about, value, isSet, onSet }: FieldProps) {
  const change = (event: Event) => {
    const input = event.currentTarget as HTMLInputElement | HTMLSelectElement;
    if (input instanceof HTMLInputElement && input.type === "checkbox") return onSet(String(input.checked));
    if (input.value.trim() === "") return onSet(null);
    onSet(about.oneOf ? JSON.stringify(input.value) : toToml(input.value.trim()));
  };
  let input;
  if (about.oneOf) {
    input = (
      <select id={id} value={String(value)} onChange={change}>
        {about.oneOf.map((one) => (
          <option value={one.const} title={one.description}>
            {one.const}
          </option>
        ))}
      </select>
    );
  } else if (about.type === "boolean") {
    input = <input id={id} type="checkbox" checked={value === true} onChange={change} />;
  } else if (about.type === "number" || about.type === "integer") {
    const number = Number(value);
    input = (
      <input id={id} type="number" step="any" min={about.minimum} max={about.maximum} value={number} onChange={change} />
    );
  } else {
    input = <input id={id} type="text" value={typeof value === "string" ? value : JSON.stringify(value)} onChange={change} />;
  }
  return (
    <div class={isSet ? "field set" : "field"} title={about.description?.replace(/^\(physical\) /, "").replaceAll("\n", " ")}>
      <label for={id}>{wordsOf(name)}</label>
      {input}
      {isSet && (
        <button type="button" class="plain" aria-label={`Reset ${name}`} title="Reset" onClick={() => onSet(null)}>
          ×
        </button>
      )}
    </div>
  );
}

const UNITS: [string, string][] = [
  ["_per_mpx", "per million"],
  ["_percent", "%"],
  ["_e_s", "electrons/s"],
  ["_e", "electrons"],
  ["_ms", "ms"],
  ["_us", "µs"],
  ["_hz", "Hz"],
  ["_c", "°C"],
  ["_m_s", "m/s"],
  ["_kg_m3", "kg/m³"],
  ["_mpa", "MPa"],
  ["_mm", "mm"],
  ["_um", "µm"],
  ["_deg", "°"],
  ["_px", "px"],
  ["_k", "K"],
  ["_m", "m"],
  ["_s", "s"],
];

/** A key as one reads it: `glass.distance_m` is "distance, m". */
function wordsOf(name: string): string {
  const key = name.replace(/^.*\./, "");
  const unit = UNITS.find(([end]) => key.endsWith(end));
  const words = (unit ? key.slice(0, -unit[0].length) : key).replaceAll("_", " ").replace(/^f number$/, "f-number").replace(/^ev$/, "exposure, EV");
  return unit ? `${words}, ${unit[1]}` : words;
}

/** A number, a list or a truth value as it is; a word in quotes. */
function toToml(text: string): string {
  if (/^(true|false|\[.*\]|[-+]?[\d.]+([eE][-+]?\d+)?)$/.test(text)) return text;
  return JSON.stringify(text.replace(/^"(.*)"$/, "$1"));
}
