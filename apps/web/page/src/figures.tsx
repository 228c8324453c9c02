// What came out, in numbers.

import type { Broken } from "./answers";

const number = (value: unknown, digits: number) =>
  typeof value === "number" && Number.isFinite(value) ? value.toLocaleString("en", { maximumFractionDigits: digits }) : "–";

const list = (fact: unknown) => (Array.isArray(fact) && fact.length > 0 ? fact.join(", ") : "none");
const percent = (fact: unknown) => `${number(100 * Number(fact), 1)} %`;
/** What says that a fault of its table is not there. */
const works = (table: string, key: string, fact: unknown) =>
  ["isp", "link", "frames"].includes(table) && (fact === 0 || key === "burst_frames" || (key === "row_bits" && fact === 16));
/** The size of each fault, as one reads it. */
const FACTS: Record<string, [string, (fact: unknown) => string]> = {
  "mud.coverage": ["covered by mud", percent],
  "mud.direct": ["light straight through", percent],
  "dust.coverage": ["covered by dust", percent],
  "dust.direct": ["light straight through", percent],
  "dust.cleanliness_level": ["cleanliness level", (fact) => number(Number(fact), 0)],
  "film.coverage": ["light that the film scatters", percent],
  "film.direct": ["light straight through", percent],
  "film.turns_by_rms_rad": ["the film bends by", (fact) => `${number(1000 * Number(fact), 2)} mrad (RMS)`],
  "frost.coverage": ["covered by ice", percent],
  "frost.direct": ["light straight through", percent],
  "scratches.coverage": ["light that scratches turn", percent],
  "scratches.direct": ["light straight through", percent],
  "scratches.haze": ["haze", percent],
  "condensation.coverage": ["covered by dew", percent],
  "condensation.direct": ["light straight through", percent],
  "condensation.refracted_px": ["wide glow", (fact) => `${number(Number(fact), 0)} px`],
  "condensation.diffracted_px": ["narrow glow", (fact) => `${number(Number(fact), 1)} px`],
  "drops.n_drops": ["drops", (fact) => number(Number(fact), 0)],
  "drops.coverage": ["covered by drops", percent],
  "drops.runs_from_mm": ["drops run from a radius of", (fact) => (fact === null ? "–" : `${number(Number(fact), 1)} mm`)],
  "distortion.corner_moves_px": ["a corner moves by", (fact) => (Array.isArray(fact) ? `${fact.map((px) => number(px, 1)).join(", ")} px` : "–")],
  "fringes.lateral_px": ["fringe in a corner", (fact) => `${number(Number(fact), 1)} px`],
  "fringes.axial_um": ["axial color error", (fact) => `${number(Number(fact), 0)} µm`],
  "defocus.disc_px": ["a point is a disc of", (fact) => `${number(Number(fact), 1)} px`],
  "shake.longest_path_px": ["path while it exposes", (fact) => `${number(Number(fact), 1)} px`],
  "ghosts.n_ghosts": ["ghosts of each lamp", (fact) => number(Number(fact), 0)],
  "ghosts.reflectance": ["a face mirrors", percent],
  "star.blades": ["blades", (fact) => number(Number(fact), 0)],
  "star.beyond_10_px": ["light beyond 10 px", percent],
  "glare.veil": ["veil", percent],
  "glare.scattered": ["light that is scattered", percent],
  "shading.corner_loss": ["a corner loses", percent],
  "lens.headroom": ["lamps may be", (fact) => `${number(Number(fact), 0)} times as bright`],
  "exposure.ev": ["exposure", (fact) => `${number(Number(fact), 1)} EV`],
  "banding.depth": ["bands", (fact) => `${number(100 * Number(fact), 1)} % of the light`],
  "banding.rows_per_band": ["a band", (fact) => `${number(Number(fact), 0)} rows`],
  "noise.snr_18": ["signal over noise, green at 18 %", (fact) => (fact === null ? "no noise" : number(Number(fact), 1))],
  "noise.dark_e": ["dark current", (fact) => `${number(Number(fact), 1)} electrons`],
  "pixels.n_defects": ["defective pixels", (fact) => number(Number(fact), 0)],
  "lines.rows": ["defective rows", list],
  "lines.columns": ["defective columns", list],
  "banding.seen": ["rows that see the LEDs", percent],
  "spots.count": ["grains of dust", (fact) => number(Number(fact), 0)],
  "spots.diameter_px": ["a usual shadow", (fact) => `${number(Number(fact), 0)} px wide`],
  "spots.depth": ["takes away", (fact) => `${percent(fact)} of the light`],
  "cfa.loss": ["color filters lost", percent],
  "mosaic.share": ["rows without colors", percent],
  "isp.black_level_percent": ["black level left in", (fact) => `${number(Number(fact), 2)} % of white`],
  "isp.white_balance": ["white balance left out", percent],
  "isp.color_matrix": ["color matrix left out", percent],
  "isp.unsharp": ["sharpening taken back", (fact) => number(Number(fact), 2)],
  "isp.tone": ["tone curve left out", percent],
  "link.bit_error_rate": ["wrong bits", (fact) => `one of ${number(1 / Number(fact), 0)}`],
  "link.jpeg_quality": ["quality of JPEG", (fact) => number(Number(fact), 0)],
  "link.row_bits": ["rows that are told apart", (fact) => number(2 ** Number(fact), 0)],
  "frames.black": ["black frames", percent],
  "frames.white": ["white frames", percent],
  "frames.frozen": ["frozen frames", percent],
  "frames.dropped": ["dropped frames", percent],
};

export function Figures({ broken, took, isOld }: { broken: Broken; took: number; isOld: boolean }) {
  const hit = broken.damage?.hits?.[0];
  const rows: [string, string][] = [["of the picture affected", `${number(100 * broken.region_share, 2)} %`]];
  if (broken.glass_disc_px !== null && broken.damage !== null) {
    rows.push(["a point of the glass", `a disc of ${number(broken.glass_disc_px, 1)} px`]);
    rows.push(["a point of the scene", broken.scene_disc_px ? `a disc of ${number(broken.scene_disc_px, 2)} px` : "sharp"]);
  }
  rows.push(["change in the region", `${number(broken.optics.contrast.rms_code, 1)} codes (RMS)`]);
  for (const [table, facts] of Object.entries(broken.faults ?? {})) {
    for (const [key, fact] of Object.entries(facts).filter(([key, fact]) => !works(table, key, fact))) {
      const [words, of] = FACTS[`${table}.${key}`] ?? [`${table}: ${key}`, (fact: unknown) => JSON.stringify(fact)];
      rows.push([words, of(fact)]);
    }
  }
  if (hit) {
    const hits = broken.damage?.hits?.length ?? 1;
    rows.push([hits > 1 ? `first of ${hits} hits` : "damage", String(hit.damage_class)]);
    rows.push(["legs", number(hit.n_legs, 0)]);
    rows.push(["peak force", `${number(hit.peak_force_n, 0)} N`]);
    rows.push(["energy of the stone", `${number(hit.kinetic_energy_j, 3)} J`]);
    rows.push(["spent on cracks", `${number(hit.dissipated_j, 4)} J`]);
  }
  return (
    <dl class={isOld ? "figures old" : "figures"} aria-busy={isOld}>
      {rows.map(([name, value]) => (
        <div key={name}>
          <dt>{name}</dt>
          <dd>{value}</dd>
        </div>
      ))}
      <div>
        <dt>computed in</dt>
        <dd>{number(took, 0)} ms</dd>
      </div>
    </dl>
  );
}

/** A time of growth in the unit that fits it. */
export function timeWords(time: number, unit: string): string {
  if (unit !== "us") return `step ${number(time, 1)}`;
  const units: [number, string][] = [
    [86_400e6, "days"],
    [3_600e6, "h"],
    [60e6, "min"],
    [1e6, "s"],
    [1e3, "ms"],
  ];
  const [size, name] = units.find(([size]) => time >= size) ?? [1, "µs"];
  return `${number(time / size, 1)} ${name}`;
}
