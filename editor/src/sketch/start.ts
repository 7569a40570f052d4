// A sketch to begin with: a body whose skin is drawn, made of the colours that flow between its surfaces.

import type { App } from '../app';
import type { Context } from '../panels/context';
import type { Json } from '../protocol';
import { bodyJson, bodyKey, bodyPlace, freeName, surfacesOf } from '../store';
import { button } from '../ui/controls';
import { h, live } from '../ui/dom';

import sketch from '../../../examples/sketch.pith';

/* What a body has of its former inside and shape, and a sketched one has no use for. */
const former = ['depth', 'direction', 'vectors', 'scale', 'displacement', 'sketch'];

/** The operations that make the chosen body a sketch of one surface. Its shape, fields and solids are replaced; cuts and
    hidden pieces of a document of one body go too. */
export function startOperations(app: App): Json[] {
  const { state } = app.store, body = bodyJson(state), place = bodyPlace(state), start = sketch as Json;
  const gone = [...former.filter((key) => key in body).map((key) => `${place}${key}`),
    ...(state.document.bodies ? [] : ['cuts', 'parts', 'camera'].filter((key) => key in state.document))];
  return [...gone.map((path) => ({ op: 'remove', path })),
    ...['shape', 'surfaces', 'solids'].map((key) => ({ op: 'set', path: `${place}${key}`, value: start[key] })),
    ...(body.solid !== undefined ? [{ op: 'solid.choose', ...bodyKey(state), name: start.solids[0].name }] : [])];
}

/** The operations that let colours flow within the shape the chosen body has: its own surface becomes the first. */
export function insideOperations(app: App): Json[] {
  const { state } = app.store, body = bodyJson(state), place = bodyPlace(state), solids = (body.solids ?? []) as Json[];
  const name = freeName('inside', (wish) => solids.some((solid) => solid.name === wish));
  return [{ op: 'set', path: `${place}surfaces`, value: [{ name: 'skin', kind: 'body', colours: { front: '#c8402f' } }] },
    { op: 'set', path: `${place}solids[${solids.length}]`, value: { name, kind: 'diffusion' } },
    ...(solids.length > 0 ? [{ op: 'solid.choose', ...bodyKey(state), name }] : [])];
}

/** Makes the chosen body a sketch, as one step, and opens the panes. */
export async function startSketch(app: App): Promise<void> {
  if (await app.actions.apply('Sketch from nothing', startOperations(app))) app.store.set({ sketching: true, selectedSurface: 'skin' });
}

/** What the panes offer while a body has no surfaces yet. */
export function startCard({ app }: Context): HTMLElement {
  const host = h('div', { class: 'sketch-start' });
  live(app.store, host, ['document', 'body', 'connection', 'sketching'], (state) =>
    !state.sketching || state.connection === 'connecting' || surfacesOf(state).length > 0 ? null : { shaped: bodyJson(state).shape !== undefined },
  (what) => what && h('div', { class: 'stage-card' },
    h('p', null, 'Nothing is sketched of this body yet. Draw its surfaces along and across an axis, colour them, and the colours ' +
      'flow between them.'),
    button('Sketch from nothing', () => void startSketch(app), { look: 'main', key: 'sketch start' }),
    what.shaped && button('Sketch inside this shape', () => void app.actions.apply('Sketch inside', insideOperations(app)),
      { key: 'sketch inside' })));
  return host;
}
