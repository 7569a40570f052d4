// The sketch of a document as the panes need it: whose curves there are, and the operations that change them.

import type { Json } from '../protocol';
import { bodyJson, bodyPlace, freeName, surfaceKey, surfaceOwner, surfacePath, surfacesOf, type State } from '../store';
import { knotsOf, pointsOf, Spline, type Knot, type Vec } from './curve';

export type PaneName = 'vertical' | 'horizontal';

/** A curve of a surface in a pane. */
export interface Curve {
  key: string;                      // tells it from all others
  surface: string;
  at: number;                       // of the surface in the body's list
  kind: string;
  pane: PaneName;
  loop: number;                     // which of several horizontal ones
  closed: boolean;
  colour: string;
  knots: Knot[];
  spline: Spline;
  /** It stands in for one that was not drawn: a circle, an oval. */
  implied: boolean;
}

/** Where the sketch of the surfaces stands in the document: beside them, in the body that has them. */
export const sketchPath = (state: State): string => `${bodyPlace(state, surfaceOwner(state))}sketch`;

export interface Folds { count: number; angle: number }

export function foldsOf(state: State): Folds {
  const { folds = 0, fold_angle: angle = 0 } = bodyJson(state).sketch ?? {};
  return { count: folds, angle };
}

/** The colour a surface shows in panes and lists. */
export const colourOf = (surface: Json): string => surface.colours?.front ?? surface.colours?.back ?? '#ffffff';

/** All curves of the chosen body. `under` has knots that a hand holds at the moment, by keys of curves. */
export function curvesOf(state: State, under: Map<string, Knot[]>): Curve[] {
  const folds = foldsOf(state);
  return surfacesOf(state).flatMap((surface, at) => {
    const { name, kind } = surface, chambers = kind === 'chambers';
    if (kind !== 'around' && !chambers) return [];
    const make = (pane: PaneName, loop: number, points: Vec[], closed: boolean, implied = false): Curve => {
      const key = `${pane} ${loop} ${name}`, knots = under.get(key) ?? knotsOf(points, closed);
      return { key, surface: name, at, kind, pane, loop, closed, knots, implied, colour: colourOf(surface),
        spline: new Spline(knots, closed, pane === 'vertical') };
    };
    const vertical = make('vertical', 0, surface.vertical, chambers || surface.closed === true);
    const loops = chambers ? surface.horizontals as Vec[][] | undefined : surface.horizontal ? [surface.horizontal as Vec[]] : undefined;
    const drawn = loops?.map((points, i) => make('horizontal', i, points, true));
    return [vertical, ...(drawn ?? [make('horizontal', 0, impliedLoop(vertical, folds), true, true)])];
  });
}

/* The loop that the library takes when none was drawn: a circle as wide as the curve, or an oval within the first fold. */
function impliedLoop({ kind, spline }: Curve, { count, angle }: Folds): Vec[] {
  const out = spline.knots.map(({ x }) => x), low = Math.min(...out), high = Math.max(...out), points = 24;
  const at = (i: number): number => (2 * Math.PI * i) / points;
  if (kind === 'around') {
    return Array.from({ length: points }, (_, i) => [high * Math.cos(at(i)), high * Math.sin(at(i))]);
  }
  const folds = Math.max(1, count), turn = (Math.PI / 180) * angle + Math.PI / folds;
  const middle = (low + high) / 2, deep = (high - low) / 2;
  const wide = folds > 2 ? Math.min(deep, 0.75 * middle * Math.tan(Math.PI / folds)) : deep;
  return Array.from({ length: points }, (_, i) =>
    turned([middle + deep * Math.cos(at(i)), wide * Math.sin(at(i))], turn));
}

export function turned([x, y]: Vec, by: number): Vec {
  return [x * Math.cos(by) - y * Math.sin(by), x * Math.sin(by) + y * Math.cos(by)];
}

/** Which fold a point lies in, from 0. */
export function foldAt({ count, angle }: Folds, x: number, y: number): number {
  if (count < 1) return 0;
  const share = ((Math.atan2(y, x) * 180) / Math.PI - angle) / (360 / count);
  return ((Math.floor(share) % count) + count) % count;
}

/** A knot list's middle. */
export function middleOf(knots: readonly Knot[]): Vec {
  return [knots.reduce((sum, { x }) => sum + x, 0) / knots.length, knots.reduce((sum, { y }) => sum + y, 0) / knots.length];
}

/* ---- operations ------------------------------------------------------------------------------------------------------ */

/** Writes the knots of a curve that is there, or, where another is implied, instead of it. `snap`: how near to the axis
    ends are moved onto it. */
export function curveOperation(state: State, curve: Curve, knots: Knot[], snap: number): Json {
  return { op: 'surface.curve', ...surfaceKey(state), surface: curve.surface, pane: curve.pane,
    ...(curve.loop > 0 ? { index: curve.loop } : {}), points: pointsOf(knots),
    ...(curve.pane === 'vertical' ? { snap: Number(snap.toPrecision(4)) } : {}) };
}

/** The operations that draw a surface's vertical curve anew. */
export function redrawVertical(state: State, surface: Json, at: number, knots: Knot[], closed: boolean, snap: number): Json[] {
  const place = surfacePath(state, at), wasClosed = surface.closed === true;
  const flag = surface.kind === 'chambers' || closed === wasClosed ? []
    : [closed ? { op: 'set', path: `${place}.closed`, value: true } : { op: 'remove', path: `${place}.closed` }];
  return [...flag, { op: 'surface.curve', ...surfaceKey(state), surface: surface.name, pane: 'vertical', points: pointsOf(knots),
    snap: Number(snap.toPrecision(4)) }];
}

/** The operations that give a surface a horizontal loop. Of chambers the first stands for all folds; one that is drawn in
    another fold gives every fold its own. */
export function drawHorizontal(state: State, surface: Json, at: number, knots: Knot[]): Json[] {
  const points = pointsOf(knots), folds = foldsOf(state);
  const curve = { op: 'surface.curve', ...surfaceKey(state), surface: surface.name, pane: 'horizontal', points };
  if (surface.kind !== 'chambers' || !surface.horizontals || folds.count < 2) return [curve];
  const loops = surface.horizontals as Vec[][], fold = foldAt(folds, ...middleOf(knots));
  const home = (loop: Vec[]): number => foldAt(folds, ...middleOf(knotsOf(loop, true)));
  if (loops.length > 1) {
    const same = loops.findIndex((loop) => home(loop) === fold);
    return [same < 0 ? curve : { ...curve, ...(same > 0 ? { index: same } : {}) }];
  }
  if (home(loops[0]) === fold) return [curve];
  return [{ op: 'set', path: `${surfacePath(state, at)}.horizontals`, value: inAllFolds(loops[0], home(loops[0]), folds)
    .map((loop, i) => (i === fold ? points : loop)) }];
}

/* A loop, and its like in every other fold, in the folds' order. */
function inAllFolds(loop: Vec[], home: number, { count }: Folds): Vec[][] {
  const round = (value: number): number => Number(value.toPrecision(7));
  return Array.from({ length: count }, (_, i) => (i === home ? loop
    : loop.map((point) => turned(point, (2 * Math.PI * (i - home)) / count).map(round) as Vec)));
}

/** Diffusion solids that list their surfaces take one more on. */
export function joinSolids(state: State, name: string): Json[] {
  const owner = surfaceOwner(state), solids = (bodyJson(state, owner).solids ?? []) as Json[];
  return solids.flatMap((solid, i) => (solid.kind === 'diffusion' && solid.surfaces
    ? [{ op: 'set', path: `${bodyPlace(state, owner)}solids[${i}].surfaces[${solid.surfaces.length}]`, value: name }] : []));
}

/** The operations that add a surface at the end of the list. */
export function addSurface(state: State, surface: Json): Json[] {
  return [{ op: 'set', path: surfacePath(state, surfacesOf(state).length), value: surface }, ...joinSolids(state, surface.name)];
}

/** A name that no surface has. */
export function freeSurfaceName(state: State, wish: string): string {
  return freeName(wish, (name) => surfacesOf(state).some((surface) => surface.name === name));
}

/** Colours of surfaces that nobody chose yet: each differs from those before. */
const firstColours = ['#c8402f', '#e8b04a', '#e9d8a6', '#7f9f3c', '#5b8fa8', '#8d6aa8', '#b5533c', '#d98c8c'];

export function nextColour(state: State): string {
  const used = new Set(surfacesOf(state).map((surface) => surface.colours?.front));
  return firstColours.find((colour) => !used.has(colour)) ?? firstColours[surfacesOf(state).length % firstColours.length];
}

/** A name to suggest for the next surface. */
export function nameFor(state: State, kind: string): string {
  if (surfacesOf(state).length === 0) return 'skin';
  return freeSurfaceName(state, { chambers: 'chambers', grains: 'seeds', body: 'skin', file: 'surface' }[kind] ?? 'flesh');
}

/** The operations that call a surface something else, everywhere it is named. */
export function renameOperations(state: State, at: number, name: string): Json[] {
  const owner = surfaceOwner(state), body = bodyJson(state, owner), place = bodyPlace(state, owner), old = surfacesOf(state)[at].name as string;
  const operations: Json[] = [{ op: 'set', path: `${surfacePath(state, at)}.name`, value: name }];
  const inList = (list: string[] | undefined, path: string): void => list?.forEach((each, i) => {
    if (each === old) operations.push({ op: 'set', path: `${path}[${i}]`, value: name });
  });
  inList(body.shape?.surfaces, `${place}shape.surfaces`);
  ((body.solids ?? []) as Json[]).forEach((solid, i) => inList(solid.surfaces, `${place}solids[${i}].surfaces`));
  surfacesOf(state).forEach((other, i) => {
    if (other.on === old) operations.push({ op: 'set', path: `${surfacePath(state, i)}.on`, value: name });
  });
  return operations;
}

/** Does a surface enclose something, so that it can bound the body? */
export function isClosed(surface: Json): boolean {
  if ((surface.erase ?? []).length > 0) return false;
  if (surface.kind === 'chambers' || surface.kind === 'grains' || surface.kind === 'file') return true;
  if (surface.kind !== 'around') return false;
  const points = surface.vertical as Vec[];
  return surface.closed === true || (points[0][0] === 0 && points[points.length - 1][0] === 0);
}

/** The surfaces that bound a body. */
export const boundsOf = (state: State, index = state.body): string[] => (bodyJson(state, index).shape?.surfaces ?? []) as string[];
