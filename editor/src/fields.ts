// A start for the fields a texture type needs, as `pith new` gives it to a mesh: the core of every component along its
// longest axis, depth 0 on the skin and 1 along the core, directions along it, and one size.

import type { MeshFacts } from './model';
import type { Json, Point, TypeNeeds } from './protocol';

export type Segment = [Point, Point];

/** What a body has of what its type needs. */
export interface Present { depth: boolean; direction: boolean; vectors: boolean; scale: boolean }

/** What of it the body's JSON has. */
export function presentIn(body: Json): Present {
  return {
    depth: (body.depth?.constraints?.length ?? 0) > 0,
    direction: (body.direction?.strokes?.length ?? 0) > 0,
    vectors: (body.vectors?.surface?.length ?? 0) + (body.vectors?.inside?.length ?? 0) > 0,
    scale: (body.scale?.points?.length ?? 0) > 0,
  };
}

/** The operations that add what a type needs and the body lacks. Needs the mesh only when something is lacking; throws
    an Error with a sentence when the mesh has no core to be found. */
export function startingOperations(needs: TypeNeeds, present: Present, mesh: MeshFacts | undefined): Json[] {
  const lacks = (key: keyof TypeNeeds): boolean => needs[key] && !present[key];
  if (!lacks('depth') && !lacks('direction') && !lacks('vectors') && !lacks('scale')) return [];
  if (!mesh) throw new Error('The mesh is not here yet; wait until it is built and try again.');
  const operations: Json[] = [], cores = coreSegments(mesh);
  if (cores.length === 0) {
    throw new Error("The mesh's longest axis does not run through its inside; draw the core with the depth stroke first.");
  }
  if (lacks('depth')) {
    operations.push({ op: 'depth.face', faces: 'all', depth: 0 });
    for (const points of cores) operations.push({ op: 'depth.stroke', points, depth: 1 });
  }
  if (lacks('direction')) for (const points of cores) operations.push({ op: 'direction.stroke', points });
  if (lacks('vectors')) for (const points of cores) operations.push({ op: 'vectors.inside', points });
  if (lacks('scale')) operations.push({ op: 'scale.point', point: middle(cores[0]), size: fittedSize(mesh) });
  return operations;
}

function middle([a, b]: Segment): Point { return [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2]; }

/** A size at which the exemplar is seen several times: half as wide as the body is thick. */
export function fittedSize(mesh: MeshFacts): number {
  const volume = mesh.closed ? signedVolume(mesh, allTriangles(mesh)) : 0;
  const [low, high] = mesh.box;
  const diagonal = Math.hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
  return Number((volume > 0 ? 0.5 * Math.cbrt(volume) : 0.25 * diagonal).toPrecision(3));
}

/** The core of every component that encloses something, at most 64: the longest stretch inside the mesh of the line
    through its middle along its longest axis, drawn in by a fifth at either end. O(triangles x components). */
export function coreSegments(mesh: MeshFacts): Segment[] {
  const found: Segment[] = [];
  for (const triangles of components(mesh).slice(0, 64)) {
    if (!(signedVolume(mesh, triangles) > 0)) continue;
    const core = coreOf(mesh, triangles);
    if (core) found.push(core);
  }
  return found;
}

function allTriangles(mesh: MeshFacts): number[] {
  return Array.from({ length: mesh.triangles.length / 3 }, (_, t) => t);
}

function corner(mesh: MeshFacts, triangle: number, k: number): Point {
  const v = 3 * mesh.triangles[3 * triangle + k];
  return [mesh.positions[v], mesh.positions[v + 1], mesh.positions[v + 2]];
}

const sub = (a: Point, b: Point): Point => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const dot = (a: Point, b: Point): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a: Point, b: Point): Point =>
  [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a: Point): Point => { const length =
  Math.hypot(...a); return [a[0] / length, a[1] / length, a[2] / length]; };

/* Triangles that hang together by their vertices, the component of the lowest vertex first. */
function components(mesh: MeshFacts): number[][] {
  const parent = Uint32Array.from({ length: mesh.positions.length / 3 }, (_, v) => v);
  const root = (v: number): number => {
    while (parent[v] !== v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (let i = 0; i < mesh.triangles.length; i += 3) {
    for (let k = 0; k < 2; ++k) {
      const a = root(mesh.triangles[i + k]), b = root(mesh.triangles[i + k + 1]);
      parent[Math.max(a, b)] = Math.min(a, b);
    }
  }
  const groups = new Map<number, number[]>();
  for (let t = 0; t < mesh.triangles.length / 3; ++t) {
    const at = root(mesh.triangles[3 * t]);
    const group = groups.get(at);
    if (group) group.push(t);
    else groups.set(at, [t]);
  }
  return [...groups].sort((a, b) => a[0] - b[0]).map(([, triangles]) => triangles);
}

function signedVolume(mesh: MeshFacts, triangles: number[]): number {
  return triangles.reduce((sum, t) => sum + dot(corner(mesh, t, 0), cross(corner(mesh, t, 1), corner(mesh, t, 2))) / 6,
    0);
}

/* Middle of a surface and the direction of its largest spread: the first eigenvector of its covariance, by repeated
   multiplication, which is enough where any of several equal axes will do. */
function longestAxis(mesh: MeshFacts, triangles: number[]): { middle: Point; axis: Point } {
  const centres = triangles.map((t) => {
    const [a, b, c] = [corner(mesh, t, 0), corner(mesh, t, 1), corner(mesh, t, 2)];
    const weight = Math.hypot(...cross(sub(b, a), sub(c, a))) / 2;
    return { weight, at: [0, 1, 2].map((k) => (a[k] + b[k] + c[k]) / 3) as Point };
  });
  const area = centres.reduce((sum, { weight }) => sum + weight, 0);
  const mean = [0, 1, 2].map((k) => centres.reduce((sum, { weight, at }) => sum + weight * at[k], 0) / area) as Point;
  const c = [[0, 0, 0], [0, 0, 0], [0, 0, 0]];
  for (const { weight, at } of centres) {
    const p = sub(at, mean);
    for (let i = 0; i < 3; ++i) for (let j = 0; j < 3; ++j) c[i][j] += weight * p[i] * p[j];
  }
  let axis = unit([c[0][0] + 1e-3 * c[1][1], c[1][1], c[2][2]]);
  for (let i = 0; i < 200; ++i) axis = unit(c.map((line) => dot(line as Point, axis)) as Point);
  return { middle: mean, axis };
}

function coreOf(mesh: MeshFacts, triangles: number[]): Segment | null {
  const { middle: at, axis } = longestAxis(mesh, triangles);
  const crossings = soundCrossings(mesh, at, axis);
  let best = 0, low = 0, high = 0;
  for (let i = 0; i + 1 < crossings.length; ++i) {
    const [a, b] = [crossings[i], crossings[i + 1]];
    // Inside: more surfaces were entered than left before this stretch.
    if (a.depth > 0 && b.at - a.at > best) { best = b.at - a.at; low = a.at; high = b.at; }
  }
  if (!(best > 0)) return null;
  const along = (t: number): Point => at.map((x, k) => rounded(x + t * axis[k], best)) as Point;
  return [along(low + best / 5), along(high - best / 5)];
}

/* A number rounded to what matters at a length: rounding of zero is zero. */
function rounded(x: number, length: number): number {
  const grain = 10 ** Math.floor(Math.log10(length) - 5);
  return Number((Math.round(x / grain) * grain).toPrecision(12)) || 0;
}

/* A line through edges or corners may miss a triangle by rounding, so one close beside the axis is taken, on which as
   many surfaces are left as are entered. */
function soundCrossings(mesh: MeshFacts, at: Point, axis: Point): { at: number; depth: number }[] {
  const side = unit(cross(axis, Math.abs(axis[0]) < 0.8 ? [1, 0, 0] : [0, 1, 0])), other = cross(axis, side);
  const [low, high] = mesh.box, step = 1e-4 * Math.hypot(...sub(high, low));
  for (let i = 1; i <= 8; ++i) {
    const turn = 2.399963 * i, away = step * i;   // a spiral by the golden angle: no two steps in line
    const from = at.map((x, k) => x + away * (Math.cos(turn) * side[k] + Math.sin(turn) * other[k])) as Point;
    const found = lineCrossings(mesh, from, axis);
    if (found.length > 0 && found.every((hit) => hit.depth >= 0) && found[found.length - 1].depth === 0) return found;
  }
  return [];
}

/* Where a line crosses the mesh, in order, with the number of surfaces that are around what follows. */
function lineCrossings(mesh: MeshFacts, from: Point, along: Point): { at: number; depth: number }[] {
  const found: { at: number; turn: number }[] = [];
  for (let t = 0; t < mesh.triangles.length / 3; ++t) {
    const a = corner(mesh, t, 0), e1 = sub(corner(mesh, t, 1), a), e2 = sub(corner(mesh, t, 2), a);
    const p = cross(along, e2), determinant = dot(e1, p);
    if (determinant === 0) continue;
    const s = sub(from, a), u = dot(s, p) / determinant, q = cross(s, e1), v = dot(along, q) / determinant;
    if (u >= 0 && v >= 0 && u + v <= 1) found.push({ at: dot(e2, q) / determinant, turn: Math.sign(determinant) });
  }
  found.sort((x, y) => x.at - y.at);
  // Through an edge or a corner a line meets several triangles at one place: they count once.
  const apart = found.filter((hit, i) => i === 0 || hit.at - found[i - 1].at > 1e-9 * (1 + Math.abs(hit.at))
    || hit.turn !== found[i - 1].turn);
  let depth = 0;
  return apart.map(({ at, turn }) => ({ at, depth: (depth += turn) }));
}
