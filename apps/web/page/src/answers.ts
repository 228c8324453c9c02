// What the module says.

export interface Named {
  name: string;
  about: string;
}

export interface Key {
  type?: string;
  description?: string;
  minimum?: number;
  maximum?: number;
  oneOf?: { const: string; description?: string }[];
}

export type Table = Record<string, unknown>;

export interface Catalog {
  version: string;
  default_preset: string;
  presets: Named[];
  cameras: Named[];
  /** Tables that turn faults on, each with what its preset says. */
  faults: Record<string, Table>;
  schema: { properties: Record<string, { properties?: Record<string, Key>; items?: { properties: Record<string, Key> } }> };
}

export interface Picture {
  name: string;
  width_px: number;
  height_px: number;
}

export interface Broken {
  region_share: number;
  optics: { contrast: { mean: number; weber: number | null; rms_code: number } };
  glass_disc_px: number | null;
  scene_disc_px: number | null;
  /** Null where no glass breaks. */
  damage: { hits?: Table[]; summary?: Table; long_crack?: Table } | null;
  /** The size of each fault of the camera. */
  faults: Record<string, Table> | null;
  last_arrival: number | null;
  unit: string | null;
  recipe: Record<string, Table | Table[]>;
  assignments: string[];
}

export interface Grown {
  time: number;
  unit: string;
  length_px: number;
}

export interface Model {
  name: string;
  /** How its outputs are read, and why so. */
  contract: string;
  reason: string;
}

export interface Box {
  class: string | null;
  score: number;
  /** Left, upper, right and lower side. */
  corners_px: [number, number, number, number];
}

export interface Found {
  boxes: Box[];
}
