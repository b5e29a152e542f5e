// What the service takes and answers, as far as the page looks into it.
export type Json = null | boolean | number | string | Json[] | { [key: string]: Json };
export type JsonObject = { [key: string]: Json };
/** The body of POST /v1/contours: whatever the user wrote, so nothing in it is taken for granted. */
export type ContourRequest = JsonObject;

export type Vec2 = [number, number];
export type Vec3 = [number, number, number];

export interface CurveInfo {
  kind: "isolux" | "caustic" | "jump" | "receiver_edge" | "boundary";
  level: number | null;
  closed: boolean;
  ends: string[];
  vertices: number;
  length: number;
  max_residual: number;
}

export interface ContourAnswer {
  id: string;
  engine_version: string;
  complete: boolean;
  families: { id: number; surfaces: string[]; flux: number }[];
  curves: CurveInfo[];
  completeness: { certified: boolean; undecided_cells: number; unproven?: string[] };
  skipped: { stage: string; reason: string }[];
  work: { evaluations: number; seconds: number };
  warnings: { code: string; detail: string }[];
  files: Record<string, string>;
  geojson?: CurveCollection;
}

export interface CurveFeature {
  properties: {
    curve_id: number;
    kind: CurveInfo["kind"];
    level: number | null;
    closed: boolean;
    family_id: number;
    parity: number;
    ring_id?: number;
    ring_order?: number;
  };
  geometry: { coordinates: Vec2[] };
}

export interface CurveCollection {
  features: CurveFeature[];
}

export interface Fault {
  pointer: string;
  detail: string;
}

export interface JobReport {
  id: string;
  status: "accepted" | "running" | "successful" | "failed" | "dismissed";
  progress: number;
  result: string | null;
  problem: { status: number; detail: string; errors?: Fault[] } | null;
}

export interface Sheet {
  family_id: number;
  E: number;
  x: Vec3;
  vertices: Vec3[];
}

export interface Reading {
  uv: Vec2;
  E: number | null;
  gradient: Vec3;
  on_caustic: boolean;
  sheets: Sheet[];
}
