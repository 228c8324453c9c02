// What a page shows, as its address holds it, and as command and Python say it.

export interface Hit {
  position: [number, number];
  azimuth_deg?: number;
  speed_m_s?: number;
}

export interface State {
  preset: string;
  severity: number;
  camera: string | null;
  /** Keys that were set, with their values as TOML. */
  set: Record<string, string>;
  hits: Hit[];
  seed: number;
}

/** What an address may say. */
const KEYS = ["preset", "severity", "camera", "set", "hit", "seed"];

const rounded = (value: number, digits: number) => Number(value.toFixed(digits));

/** A hit at a place of the picture, with numbers short enough for an address. */
export function hitAt(x: number, y: number, drag?: { azimuth: number; speed: number }): Hit {
  const inside = (value: number) => rounded(Math.min(Math.max(value, 0), 1), 4);
  const hit: Hit = { position: [inside(x), inside(y)] };
  if (drag) {
    hit.azimuth_deg = rounded(drag.azimuth, 1);
    hit.speed_m_s = rounded(drag.speed, 1);
  }
  return hit;
}

/** The keys that were set, as `--set` has them. */
const assignmentsOf = (state: State) => Object.entries(state.set).map(([key, value]) => `${key}=${value}`);

export function question(state: State, isDraft: boolean): Record<string, unknown> {
  return {
    ask: "break",
    preset: state.preset,
    severity: state.severity,
    camera: state.camera,
    set: assignmentsOf(state),
    hits: state.hits,
    seed: state.seed,
    is_draft: isDraft,
  };
}

export function toAddress(state: State): string {
  const words = new URLSearchParams();
  words.set("preset", state.preset);
  words.set("severity", String(state.severity));
  if (state.camera !== null) words.set("camera", state.camera);
  for (const text of assignmentsOf(state)) words.append("set", text);
  for (const hit of state.hits) {
    words.append("hit", [...hit.position, hit.azimuth_deg, hit.speed_m_s].filter((v) => v !== undefined).join(","));
  }
  words.set("seed", String(state.seed));
  return `#${words}`;
}

/** The state of an address, where what it does not say is as in `start`, and what it says that means nothing. */
export function fromAddress(hash: string, start: State): { state: State; left: string[] } {
  const words = new URLSearchParams(hash.replace(/^#/, ""));
  const left: string[] = [];
  const whole = (key: string, least: number, most: number) => {
    const text = words.get(key);
    if (text === null) return null;
    const value = Number(text);
    if (text.trim() !== "" && Number.isInteger(value) && value >= least && value <= most) return value;
    left.push(`${key}=${text} (a whole number from ${least} to ${most} is expected)`);
    return null;
  };
  const set: Record<string, string> = {};
  for (const text of words.getAll("set")) {
    const at = text.indexOf("=");
    if (at > 0) set[text.slice(0, at).trim()] = text.slice(at + 1).trim();
    else left.push(`set=${text} (a key and its value, key=value, are expected)`);
  }
  const hits = words.getAll("hit").flatMap((text) => {
    const numbers = text.split(",").map((part) => (part.trim() === "" ? NaN : Number(part)));
    const [x, y, azimuth, speed] = numbers;
    if (x === undefined || y === undefined || ![2, 4].includes(numbers.length) || !numbers.every(Number.isFinite)) {
      left.push(`hit=${text} (x,y or x,y,azimuth,speed are expected)`);
      return [];
    }
    const hit: Hit = { position: [x, y] };
    if (azimuth !== undefined && speed !== undefined) Object.assign(hit, { azimuth_deg: azimuth, speed_m_s: speed });
    return [hit];
  });
  for (const key of new Set(words.keys())) {
    if (!KEYS.includes(key)) left.push(`${key} (${KEYS.join(", ")} are known)`);
  }
  const state = {
    preset: words.get("preset") ?? start.preset,
    severity: whole("severity", 1, 5) ?? start.severity,
    camera: words.get("camera") ?? start.camera,
    set,
    hits,
    seed: whole("seed", 0, Number.MAX_SAFE_INTEGER) ?? start.seed,
  };
  return { state, left };
}

const quoted = (text: string) => (/^[\w./=,][\w./=,-]*$/.test(text) ? text : `'${text.replaceAll("'", `'\\''`)}'`);

/** Name of the recipe among the downloads of a picture. */
const recipeFile = (name: string) => `${name.replace(/\.[^.]*$/, "")}.recipe.toml`;

/** The command that writes this picture; several hits need the recipe as a file. */
export function toCommand(state: State, assignments: string[], name: string): string {
  const words = ["starbreak", "crack", quoted(name.startsWith("-") ? `./${name}` : name)];
  if (state.hits.length > 1) {
    words.push("--recipe", quoted(recipeFile(name)));
  } else {
    words.push("--preset", quoted(state.preset));
    words.push("--severity", String(state.severity));
    if (state.camera !== null) words.push("--camera", quoted(state.camera));
    for (const text of [...assignmentsOf(state), ...assignments]) words.push("--set", quoted(text));
  }
  // The page writes PNG; the command writes what it reads.
  if (!/\.png$/i.test(name)) words.push("--set", "output.format=png");
  words.push("--seed", String(state.seed), "--output", "out");
  return words.join(" ");
}

/** The same in Python. */
export function toPython(state: State, assignments: string[], name: string): string {
  const literal = (toml: string) => {
    if (/^[-+]?(inf|nan)$/.test(toml)) return `float("${toml}")`;
    const isAlike = /^([-+]?[\d._]+([eE][-+]?\d+)?|\[[-+\d.,\s_eE]*\]|".*"|'.*')$/.test(toml);
    return { true: "True", false: "False" }[toml] ?? (isAlike ? toml : JSON.stringify(toml));
  };
  let recipe: string;
  if (state.hits.length > 1) {
    recipe = `starbreak.Recipe.from_file(${JSON.stringify(recipeFile(name))})`;
  } else {
    const words = [JSON.stringify(state.preset)];
    words.push(`severity=${state.severity}`);
    if (state.camera !== null) words.push(`camera=${JSON.stringify(state.camera)}`);
    const set = [...assignmentsOf(state), ...assignments].map((text) => {
      const at = text.indexOf("=");
      return `${JSON.stringify(text.slice(0, at))}: ${literal(text.slice(at + 1))}`;
    });
    if (set.length > 0) words.push(`set={${set.join(", ")}}`);
    recipe = `starbreak.Recipe(${words.join(", ")})`;
  }
  return [
    "import starbreak",
    "from PIL import Image, ImageOps",
    `photo = ImageOps.exif_transpose(Image.open(${JSON.stringify(name)})).convert("RGB")`,
    `cracked = starbreak.crack(photo, ${recipe}, seed=starbreak.item_seed(${state.seed}, ${JSON.stringify(name)}))`,
    "",
  ].join("\n");
}
