// Grains strewn over a surface: how many and how large, and the form of one, drawn in a small pane of its own.

import { setValue, removeValue } from '../app';
import type { Context } from '../panels/context';
import { optionRows } from '../panels/options';
import type { Json } from '../protocol';
import { button, choice, iconButton, row, segmented } from '../ui/controls';
import { h, recall, remember, type Child } from '../ui/dom';
import { section } from '../ui/layout';
import { many } from '../ui/numbers';
import { numberField } from '../ui/slider';
import { surfacesOf } from '../store';
import { clearLine, dot, themeColour } from './draw';
import { area2, distance, knotsOf, pointsOf, Spline, type Knot, type Vec } from './curve';
import { colourOf } from './drawn';
import { fitStroke, tidy } from './fit';

/** Keys of new grains: flat drops, as seeds are. */
export function freshGrains(on: string, size: number): Json {
  const long = 0.07 * size, thick = 0.03 * size, round = (value: number): number => Number(value.toPrecision(3));
  const loop = (half: number): Vec[] => Array.from({ length: 8 }, (_, i): Vec =>
    [round(thick * Math.cos((i / 4) * Math.PI)), round(half * Math.sin((i / 4) * Math.PI))]);
  return { on, radius: round(0.2 * size), grain: { profile: loop(long), outline: loop(0.6 * long) } };
}

/** The rows of a surface of grains. */
export function grainRows(context: Context, surface: Json, path: string): Child {
  const { app } = context, { state } = app.store, surfaces = surfacesOf(state), at = surfaces.indexOf(surface);
  const before = surfaces.slice(0, at < 0 ? surfaces.findIndex(({ name }) => name === surface.name) : at).filter(({ kind }) => kind !== 'grains');
  const region = (surface.region ?? []) as Json[], far = 10 * (surface.radius ?? 0.1);
  return [row('On', choice('Surface they lie on', before.map(({ name }) => ({ value: name as string, label: name as string })), surface.on,
    (on) => void setValue(app, 'Strew grains on another surface', `${path}.on`, on), { key: `${path}.on` }).element),
  optionRows(app, path, { of: 'grains', only: ['radius', 'scale', 'scale_spread', 'turn_spread', 'offset', 'seed'],
    more: ['turn_spread', 'offset', 'seed'], soft: { radius: [far / 200, far / 2], scale: [0.1, 4], offset: [-far / 20, far / 20] } }),
  grainForm(context, surface, path),
  region.length > 0 ? regionRows(context, region, path)
    : h('p', { class: 'quiet' }, 'They are strewn everywhere; draw with “Strew” along the axis to say where.')];
}

/* Where grains are strewn, as brushes say. */
function regionRows({ app }: Context, region: Json[], path: string): HTMLElement {
  const fold = section('grains.region', `Where (${region.length})`, { folded: true, inner: true });
  fold.body.append(h('ul', { class: 'list', 'aria-label': 'Where grains are strewn' }, region.map((brush, i) => h('li', { class: 'list-row' },
    h('div', { class: 'list-line' }, h('span', { class: 'list-main' }, many(brush.points?.length ?? 0, 'point')),
      h('span', { class: 'list-actions' }, numberField('Radius of the brush', { min: 0, max: 1e9, soft: [0, 10 * (brush.radius || 0.1)] }, brush.radius ?? 0,
        (radius) => void setValue(app, 'Width of the brush', `${path}.region[${i}].radius`, radius), { key: `${path}.region[${i}].radius` }).element, iconButton('trash', 'Remove this brush',
        () => void removeValue(app, 'Strew fewer places', region.length === 1 ? `${path}.region` : `${path}.region[${i}]`),
        { look: 'plain', key: `${path}.region[${i}]-` })))))));
  return fold.element;
}

/* ---- the form of one ------------------------------------------------------------------------------------------------- */

type Side = 'profile' | 'outline';
const size = 190, grip = 9;

/* A small pane: the surface below as a line, the grain on it; z upwards, along the axis (or across it) to the right. Points
   are dragged; a stroke on the ground draws the loop anew. */
function grainForm({ app }: Context, surface: Json, path: string): HTMLElement {
  const kept = recall('sketch.grain') === 'outline' ? 'outline' : 'profile';
  let side: Side = kept, knots: Knot[] = [], stroke: Vec[] | null = null, held = -1;
  const canvas = h('canvas', { class: 'grain-pane', width: 2 * size, height: 2 * size, tabindex: 0,
    'aria-label': 'The form of a grain; drag its points, or draw it anew', 'data-tip': 'Drag its points, or draw it anew' });
  const back = button('As the profile', () => void removeValue(app, 'Outline as the profile', `${path}.grain.outline`),
    { look: 'plain', key: `${path}.grain.outline-` });
  const grain = surface.grain as { profile: Vec[]; outline?: Vec[] };
  const given = (): Vec[] => (side === 'outline' && grain.outline) || grain.profile;
  const reach = 1.35 * Math.max(...[...grain.profile, ...(grain.outline ?? [])].flat().map(Math.abs), 1e-9);
  const zoom = size / 2 / reach, screen = (z: number, s: number): Vec => [size / 2 + s * zoom, size / 2 - z * zoom];
  const model = (event: MouseEvent): Vec => {
    const box = canvas.getBoundingClientRect(), scale = size / (box.width || size);
    return [(size / 2 - (event.clientY - box.top) * scale) / zoom, ((event.clientX - box.left) * scale - size / 2) / zoom];
  };

  function draw(): void {
    const brush = canvas.getContext('2d')!;
    brush.setTransform(2, 0, 0, 2, 0, 0);
    brush.clearRect(0, 0, size, size);
    brush.lineJoin = brush.lineCap = 'round';
    brush.fillStyle = themeColour('pane-shade');
    brush.fillRect(0, size / 2, size, size / 2);
    clearLine(brush, [[0, size / 2], [size, size / 2]], '#3fae5a', 1.5);
    const line = stroke ?? new Spline(knots, true).line;
    clearLine(brush, line.map(([z, s]) => screen(z, s)), colourOf(surface), 2.5);
    if (!stroke) for (const { x, y } of knots) dot(brush, screen(x, y), 3.5, '#ffffff', '#202020');
    brush.fillStyle = themeColour('quiet');
    brush.font = '11px system-ui, sans-serif';
    brush.textAlign = 'right';
    brush.fillText(side === 'profile' ? 'along the axis →' : 'across →', size - 5, size - 6);
  }
  function show(): void {
    knots = knotsOf(given(), true);
    back.hidden = side !== 'outline' || !grain.outline;
    draw();
  }
  const write = (next: Knot[]): void => {
    const loop = tidy(next, 1 / zoom);
    void setValue(app, side === 'profile' ? 'Draw the grain’s profile' : 'Draw the grain’s outline', `${path}.grain.${side}`, pointsOf(loop))
      .then((done) => { if (!done) show(); });
  };
  canvas.addEventListener('pointerdown', (event) => {
    const [z, s] = model(event);
    canvas.setPointerCapture(event.pointerId);
    held = knots.findIndex(({ x, y }) => distance(x, y, z, s) * zoom < grip);
    stroke = held < 0 ? [[z, s]] : null;
  });
  canvas.addEventListener('pointermove', (event) => {
    if (!canvas.hasPointerCapture(event.pointerId)) return;
    const [z, s] = model(event);
    if (held >= 0) knots = knots.map((knot, i) => (i === held ? { ...knot, x: z, y: s } : knot));
    else stroke?.push([z, s]);
    draw();
  });
  canvas.addEventListener('pointercancel', () => {
    stroke = null;
    held = -1;
    show();
  });
  canvas.addEventListener('pointerup', () => {
    const drawn = stroke, moved = held;
    stroke = null;
    held = -1;
    if (moved >= 0) return write(knots);
    if (!drawn || drawn.length < 6 || Math.abs(area2(drawn)) * zoom * zoom < 200) return show();
    write(fitStroke(drawn, true, { pixel: 1 / zoom, half: false }));
  });
  const made = h('div', { class: 'grain-form' }, segmented('View of the grain', [
    { value: 'profile', label: 'Profile', tip: 'Seen from the side: out of the surface, and along the axis' },
    { value: 'outline', label: 'Outline', tip: 'Seen along the axis: out of the surface, and across' },
  ], side, (next) => { side = next; remember('sketch.grain', next); show(); }, { key: `${path}.grain side` }).element, canvas, back,
  optionRows(app, `${path}.grain`, { of: 'grain', only: ['across', 'along'], more: ['across', 'along'] }));
  requestAnimationFrame(show);
  return made;
}
