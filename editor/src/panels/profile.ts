// The profile of a turned body: a drawing of it, and its points from the lowest up.

import { setValue, type App } from '../app';
import type { Json } from '../protocol';
import { schemaAt, valueAt } from '../schema';
import { checkbox, iconButton } from '../ui/controls';
import { h, live, svg, type Child } from '../ui/dom';
import { numberField } from '../ui/slider';

interface ProfilePoint { z: number; r: number; corner?: boolean }

/** The editor of the list at a path. */
export function profileEditor(app: App, path: string): HTMLElement {
  const host = h('div', { class: 'profile' });
  live(app.store, host, ['document', 'schema'], (state) => {
    const points = (valueAt(state.document, path) ?? []) as ProfilePoint[];
    return { points, about: about(state.schema, state.document, path) };
  }, (what) => body(app, path, what.points, what.about));
  return host;
}

/* Limits and sentences of the three values. */
function about(schema: Json, document: Json, path: string): Json {
  const properties = schemaAt(schema, document, `${path}[0]`)?.properties ?? {};
  return Object.fromEntries(['z', 'r', 'corner'].map((key) => [key, { min: properties[key]?.minimum ?? -1e6,
    max: properties[key]?.maximum ?? 1e6, help: properties[key]?.description ?? '' }]));
}

function body(app: App, path: string, points: ProfilePoint[], facts: Json): Child {
  const put = (step: string, next: ProfilePoint[]): Promise<boolean> => setValue(app, step, path, next);
  const edit = (i: number, change: Partial<ProfilePoint>): void => {
    const next = points.map((point, k) => (k === i ? { ...point, ...change } : point));
    if (change.corner === false) delete next[i].corner;
    void put(`Set point ${i + 1} of the profile`, next);
  };
  const reach = Math.max(...points.map(({ z }) => Math.abs(z)), ...points.map(({ r }) => r), 1e-3);
  const number = (i: number, key: 'z' | 'r'): HTMLElement => {
    const { min, max } = facts[key], least = key === 'z' && i > 0 ? points[i - 1].z : min;
    const most = key === 'z' && i + 1 < points.length ? points[i + 1].z : max;
    return numberField(`${key} of point ${i + 1}`, { min: least, max: most, soft: [key === 'z' ? -reach : 0, reach] }, points[i][key],
      (value) => edit(i, { [key]: value }), { key: `${path}[${i}].${key}` }).element;
  };
  const rows = points.map((point, i) => h('li', null, h('span', { class: 'mini-label', 'aria-hidden': 'true' }, String(i + 1)),
    number(i, 'z'), number(i, 'r'),
    checkbox('', point.corner ?? false, (corner) => edit(i, { corner }), { key: `${path}[${i}].corner`, name: `Edge at point ${i + 1}` }).element,
    h('span', { class: 'operand-actions' },
      iconButton('plus', `Add a point after point ${i + 1}`, () => void put('Add point to the profile',
        [...points.slice(0, i + 1), between(points, i), ...points.slice(i + 1)]), { look: 'plain', key: `${path}[${i}]+` }),
      iconButton('trash', `Remove point ${i + 1}`, () => void put('Remove point of the profile', points.filter((_, k) => k !== i)),
        { look: 'plain', key: `${path}[${i}]-`, disabled: points.length <= 2 }))));
  return [h('div', { class: 'sub-head' }, h('h4', { 'data-tip': 'From the lowest point up.' }, 'Profile')),
    drawing(points),
    h('div', { class: 'profile-head', 'aria-hidden': 'true' }, h('span'), h('span', { 'data-tip': facts.z.help }, 'Height'),
      h('span', { 'data-tip': facts.r.help }, 'Radius'), h('span', { 'data-tip': facts.corner.help }, 'Edge')),
    h('ol', { class: 'profile-points' }, rows)];
}

/* A point halfway to the next, or a little beyond the last. */
function between(points: ProfilePoint[], i: number): ProfilePoint {
  const a = points[i], b = points[i + 1], round = (value: number): number => Number(value.toPrecision(4));
  if (b) return { z: round((a.z + b.z) / 2), r: round((a.r + b.r) / 2) || round(Math.max(a.r, b.r, 0.1) / 2) };
  const span = a.z - points[0].z || 1;
  return { z: round(a.z + span / 4), r: a.r };
}

/* Lying as on a lathe, its lower end on the left: both sides of the axis, the points as dots, smooth through those that
   are no edges. */
function drawing(points: ProfilePoint[]): SVGElement {
  const low = Math.min(...points.map(({ z }) => z)), high = Math.max(...points.map(({ z }) => z));
  const wide = Math.max(...points.map(({ r }) => r)) || 1, tall = high - low || 1, unit = Math.max(2 * wide, tall) / 100;
  const at = ({ z, r }: ProfilePoint, side: number): [number, number] => [(z - low) / unit, (-side * r) / unit];
  const word = ([x, y]: [number, number]): string => `${x.toFixed(2)} ${y.toFixed(2)}`;
  const line = (side: number): string => points.map((point, i) => {
    if (i === 0) return `M${word(at(point, side))}`;
    const from = at(points[i - 1], side), to = at(point, side);
    const a = tangent(points, i - 1).map((d, k) => from[k] + ((k === 0 ? 1 : -side) * d) / (3 * unit));
    const b = tangent(points, i).map((d, k) => to[k] - ((k === 0 ? 1 : -side) * d) / (3 * unit));
    const straight = points[i - 1].z === point.z;
    return straight ? `L${word(to)}` : `C${word(a as [number, number])} ${word(b as [number, number])} ${word(to)}`;
  }).join('');
  const box = [-3, -wide / unit - 3, tall / unit + 6, (2 * wide) / unit + 6].map((value) => value.toFixed(1)).join(' ');
  return svg('svg', { class: 'profile-drawing', viewBox: box, role: 'img', 'aria-label': `Profile of ${points.length} points` },
    svg('path', { class: 'profile-side', d: line(1) }), svg('path', { class: 'profile-side', d: line(-1) }),
    svg('path', { class: 'profile-axis', d: `M-2 0H${(tall / unit + 2).toFixed(1)}` }),
    points.map((point) => {
      const [x, y] = at(point, 1);
      return svg('circle', { class: point.corner ? 'profile-point edge' : 'profile-point', cx: x.toFixed(2), cy: y.toFixed(2), r: 1.1 });
    }));
}

/* How z and r go on at a point, over the stretch beside it: none at edges and where the profile is level. */
function tangent(points: ProfilePoint[], i: number): [number, number] {
  const before = points[i - 1], here = points[i], after = points[i + 1];
  if (here.corner || !before || !after) return [0, 0];
  return [(after.z - before.z) / 2, (after.r - before.r) / 2];
}
