// Inspector, "Sketch": the surfaces of the body, its symmetry, and its random variations.

import type { Context } from '../panels/context';
import { optionRows } from '../panels/options';
import { surfaceEye } from '../panels/surfaceoptions';
import { removeValue } from '../app';
import { isTwoSided } from '../surfaceview';
import type { Json } from '../protocol';
import { bodyJson, bodyKey, bodyPlace, surfaceKey, surfaceOwner, surfacePath, surfacesOf, type State } from '../store';
import { button, row } from '../ui/controls';
import { h, live, type Child } from '../ui/dom';
import { menuButton, type MenuItem } from '../ui/floating';
import { icon, type IconName } from '../ui/icons';
import { badge, empty, list, listRow, section, setNote } from '../ui/layout';
import { slider } from '../ui/slider';
import { addSurface, boundsOf, colourOf, foldsOf, freeSurfaceName, isClosed, middleOf, nameFor, nextColour, sketchPath, turned } from './drawn';
import { knotsOf, type Vec } from './curve';
import type { Session } from './session';
import { surfaceMore } from './surface';
import { startSketch, insideOperations } from './start';
import { freshGrains } from './grains';
import { fileDialog } from '../dialogs/pick';

/** The sections of the tab. */
export function sketchPanel(context: Context, session: Session): HTMLElement {
  return h('div', { class: 'panel' }, surfacesSection(context, session), symmetrySection(context), variationSection(context));
}

const kindIcons: { [kind: string]: IconName } = { around: 'around', chambers: 'chambers', grains: 'grain', file: 'folder', body: 'body' };
const kindWords: { [kind: string]: string } = {
  around: 'Around the axis', chambers: 'A chamber in each fold', grains: 'Grains', file: 'A mesh file', body: 'The body’s own surface',
};

/* ---- surfaces --------------------------------------------------------------------------------------------------------- */

function surfacesSection(context: Context, session: Session): HTMLElement {
  const { app } = context, { store } = app, part = section('sketch.surfaces', 'Surfaces');
  live(store, part.body, ['document', 'body', 'selectedSurface', 'shownSurfaces', 'sketching', 'schema'], (state) => ({
    surfaces: surfacesOf(state), chosen: state.selectedSurface, shown: state.shownSurfaces, bounds: boundsOf(state),
    place: bodyPlace(state), open: state.sketching, folds: foldsOf(state),
  }), ({ surfaces, chosen, open, bounds }) => {
    setNote(part, surfaces.length ? String(surfaces.length) : null);
    const mode = !open && commandSketch(context);
    if (surfaces.length === 0) {
      return empty('Nothing is sketched of this body. Its inside can be made of colours that flow between surfaces.',
        [button('Sketch from nothing', () => void startSketch(app), { look: 'main', key: 'panel start' }),
          bodyJson(store.state).shape && button('Sketch inside this shape',
            () => void app.actions.apply('Sketch inside', insideOperations(app)), { key: 'panel inside' })]);
    }
    return [mode, list('Surfaces', surfaces.map((surface, i) =>
      surfaceRow(context, session, surface, i, surface.name === chosen, bounds.includes(surface.name)))),
    h('div', { class: 'actions' }, addButton(context))];
  });
  return part.element;
}

function commandSketch(context: Context): Child {
  return h('div', { class: 'actions sketch-open' }, button('Open the sketch', () => context.app.store.set({ sketching: true }),
    { icon: 'sketch', keys: context.commands.get('sketch').keys[0], key: 'panel open', look: 'main' }));
}

function surfaceRow(context: Context, session: Session, surface: Json, at: number, chosen: boolean, bounds: boolean): HTMLElement {
  const { store } = context.app, { name } = surface;
  const back = surface.colours?.back;
  const made = listRow({
    icon: kindIcons[surface.kind], text: name, chosen, key: `surface ${name}`,
    lead: h('span', { class: 'colour-dots', 'aria-hidden': 'true' },
      [colourOf(surface), back].filter(Boolean).map((colour) => h('span', { class: 'colour-dot', style: `--colour: ${colour}` }))),
    detail: kindWords[surface.kind], choose: () => store.set({ selectedSurface: chosen ? null : name }),
    actions: [bounds && badge('skin', 'plain', 'It bounds the body.'),
      surfaceEye(context, name),
      menu(context, session, surface, at, bounds)],
    more: chosen && surfaceMore(context, session, surface, at),
  });
  return made;
}

function menu({ app }: Context, session: Session, surface: Json, at: number, bounds: boolean): HTMLElement {
  const { state } = app.store, surfaces = surfacesOf(state), place = bodyPlace(state, surfaceOwner(state));
  const anchor = h('button', { type: 'button', class: 'icon-button plain', 'aria-label': `More about ${surface.name}`,
    'data-tip': 'Order, copy, remove…', 'data-key': `surface menu ${surface.name}` }, icon('more', 18));
  const move = (to: number, name: string): void => {
    const order = surfaces.slice();
    order.splice(to, 0, ...order.splice(at, 1));
    void app.actions.apply(name, [{ op: 'set', path: `${place}surfaces`, value: order }]);
  };
  return menuButton(anchor, () => {
    const items: (MenuItem | null)[] = [
      { label: 'Duplicate', icon: 'copy', run: () => void duplicate(session, surface) },
      { label: 'Flip its colours', icon: 'flip', disabled: !isTwoSided(surface), run: () => void app.actions.apply(`Flip ${surface.name}`,
        [{ op: 'surface.flip', ...surfaceKey(state), surface: surface.name }]) },
      null,
      { label: 'Move up', icon: 'up', disabled: at === 0, run: () => move(at - 1, `Move ${surface.name} up`) },
      { label: 'Move down', icon: 'down', disabled: at === surfaces.length - 1, run: () => move(at + 1, `Move ${surface.name} down`) },
      null,
      { label: bounds ? 'Let it bound the body no more' : 'Let it bound the body', icon: 'body', disabled: !bounds && !isClosed(surface),
        run: () => void toggleBounds(session, surface, bounds) },
      null,
      { label: 'Remove', icon: 'trash', danger: true, run: () => void removeSurface(session, surface) },
    ];
    return items;
  });
}

async function duplicate({ app }: Session, surface: Json): Promise<void> {
  const { store } = app, name = freeSurfaceName(store.state, surface.name);
  if (await app.actions.apply(`Duplicate ${surface.name}`, addSurface(store.state, { ...surface, name }))) store.set({ selectedSurface: name });
}

/** Takes a surface away, and what says that it bounds the body; the last one that does stays. */
export async function removeSurface({ app }: Session, surface: Json): Promise<void> {
  const { store } = app, { name } = surface, owner = surfaceOwner(store.state), bounds = boundsOf(store.state, owner), rest = bounds.filter((each) => each !== name);
  if (bounds.includes(name) && rest.length === 0) {
    return app.messages.say(`${name} bounds the body; let another closed surface bound it first.`, 'warning');
  }
  const shape = rest.length < bounds.length ? [{ op: 'set', path: `${bodyPlace(store.state, owner)}shape.surfaces`, value: rest }] : [];
  const done = await app.actions.apply(`Remove ${name}`, [...shape, { op: 'surface.remove', ...bodyKey(store.state, owner), surface: name }]);
  if (done && store.state.selectedSurface === name) store.set({ selectedSurface: null });
}

/** Lets a surface be part of what bounds the body, or no longer. */
export async function toggleBounds({ app }: Session, { name }: Json, bounds: boolean): Promise<void> {
  const { state } = app.store, now = boundsOf(state), path = `${bodyPlace(state)}shape`;
  if (bounds && now.length === 1) {
    return app.messages.say('Something must bound the body; let another closed surface do so first.', 'warning');
  }
  const kept = Object.fromEntries(Object.entries(bodyJson(state).shape ?? {}).filter(([key]) => ['tets', 'place', 'refine'].includes(key)));
  const operation = now.length > 0
    ? { op: 'set', path: `${path}.surfaces`, value: bounds ? now.filter((each) => each !== name) : [...now, name] }
    : { op: 'set', path, value: { surfaces: [name], ...kept } };
  await app.actions.apply(bounds ? `${name} bounds the body no more` : `${name} bounds the body`, [operation]);
}

/* ---- new ones --------------------------------------------------------------------------------------------------------- */

function addButton({ app }: Context): HTMLElement {
  const { store } = app;
  const anchor = button('Add a surface', () => {}, { icon: 'plus', key: 'add surface' });
  const add = async (surface: Json): Promise<void> => {
    if (await app.actions.apply(`Add ${surface.name}`, addSurface(store.state, surface))) store.set({ selectedSurface: surface.name });
  };
  const fresh = (kind: string): Json => ({ name: nameFor(store.state, kind), kind });
  const coloured = (surface: Json): Json => ({ ...surface, colours: { front: nextColour(store.state) } });
  return menuButton(anchor, () => {
    const { state } = store, folds = foldsOf(state).count, bases = surfacesOf(state).filter(({ kind }) => kind !== 'grains');
    const size = sizeOf(state);
    return [
      { label: 'Around the axis', icon: 'around', run: () => void add(coloured({ ...fresh('around'), vertical: roundProfile(0.6 * size) })) },
      { label: folds > 0 ? 'A chamber in each fold' : 'A chamber in each fold (needs folds)', icon: 'chambers', disabled: folds === 0,
        run: () => void add(coloured({ ...fresh('chambers'), vertical: chamberLoop(size) })) },
      { label: 'Grains on a surface', icon: 'grain', disabled: bases.length === 0,
        run: () => void add(coloured({ ...fresh('grains'), ...freshGrains((state.selectedSurface !== null
          && bases.find(({ name }) => name === state.selectedSurface)?.name) || bases[bases.length - 1].name, size) })) },
      { label: 'A mesh file…', icon: 'folder', run: () => fileDialog(app, 'mesh', (mesh) => void add({ ...fresh('file'), mesh })) },
      { label: 'The body’s own surface', icon: 'body', disabled: boundsOf(state).length > 0 || surfacesOf(state).some(({ kind }) => kind === 'body'),
        run: () => void add(coloured(fresh('body'))) },
    ];
  });
}

/** How far the sketch reaches from the axis. */
export function sizeOf(state: State): number {
  const radii = surfacesOf(state).flatMap(({ vertical }) => ((vertical ?? []) as Vec[]).map(([r]) => r));
  return Math.max(...radii, 0) || 1;
}

const round = (value: number): number => Number(value.toPrecision(3));

/* Half an ellipse from the axis to the axis. */
function roundProfile(size: number): Vec[] {
  return [[0, 0.9], [0.64, 0.64], [0.9, 0], [0.64, -0.64], [0, -0.9]].map(([r, z]) => [round(r * size), round(z * size)] as Vec);
}

/* A loop beside the axis. */
function chamberLoop(size: number): Vec[] {
  return [[0.3, 0], [0.42, 0.36], [0.62, 0.36], [0.75, 0], [0.62, -0.36], [0.42, -0.36]]
    .map(([r, z]) => [round(r * size), round(z * size)] as Vec);
}

/* ---- symmetry --------------------------------------------------------------------------------------------------------- */

function symmetrySection({ app }: Context): HTMLElement {
  const { store } = app, part = section('symmetry', 'Symmetry');
  live(store, part.body, ['document', 'body', 'schema'], (state) => ({ folds: foldsOf(state), path: sketchPath(state),
    there: surfacesOf(state).length > 0 }), ({ folds, path, there }) => {
    part.show(there);
    setNote(part, folds.count > 0 ? `${folds.count}-fold` : 'all round');
    return [row('Folds', slider('Folds', { min: 0, max: 64, whole: true, default: 0, soft: [0, 16] }, folds.count,
      (count) => void app.actions.apply('Set folds', setFolds(app.store.state, count)),
      { key: 'sketch folds' }).element, { tip: 'How often the structure repeats round the axis; 0: it is alike all round.' }),
    folds.count > 0 && optionRows(app, path, { only: ['fold_angle'], of: 'sketch', soft: { fold_angle: [0, 360] } })];
  });
  return part.element;
}

/* Loops of chambers are one in each fold: with another number of folds the first stands for all, where its fold is now. */
function setFolds(state: State, count: number): Json[] {
  const before = foldsOf(state), operations: Json[] = [{ op: 'set', path: `${sketchPath(state)}.folds`, value: count }];
  surfacesOf(state).forEach((surface, i) => {
    const loops = surface.horizontals as Vec[][] | undefined;
    if (!loops?.length || count === 0) return;
    const wide = 360 / count, [x, y] = middleOf(knotsOf(loops[0], true)), at = (Math.atan2(y, x) * 180) / Math.PI - before.angle;
    const middle = (Math.floor(at / wide) + 0.5) * wide; // of the fold that it lies in now
    const moved = loops[0].map((point) => turned(point, ((middle - at) * Math.PI) / 180).map((value) => Number(value.toPrecision(7))));
    operations.push({ op: 'set', path: `${surfacePath(state, i)}.horizontals`, value: [moved] });
  });
  return operations;
}

/* ---- variation -------------------------------------------------------------------------------------------------------- */

function variationSection({ app }: Context): HTMLElement {
  const { store } = app, part = section('variation', 'Variation');
  live(store, part.body, ['document', 'body', 'schema'], (state) => ({ variation: (bodyJson(state).sketch?.variation ?? null) as Json | null,
    path: `${bodyPlace(state)}sketch`, there: surfacesOf(state).some(({ kind }) => kind === 'around' || kind === 'chambers') }),
  ({ variation, path, there }) => {
    part.show(there);
    setNote(part, variation ? `seed ${variation.seed ?? 0}` : 'as drawn');
    const another = (): void => void app.actions.apply('Another one of its kind', [{ op: 'sketch.vary', ...bodyKey(store.state),
      ...variation, seed: 1 + Math.floor(Math.random() * 9999) }]);
    return [h('p', { class: 'quiet' }, 'Another individual of the same kind: what is drawn across is made anew, after its own unevenness.'),
      h('div', { class: 'actions' }, button('Another one', another, { icon: 'dice', key: 'vary' }),
        variation && button('As it was drawn', () => void removeValue(app, 'As it was drawn', `${path}.variation`),
          { icon: 'return', key: 'not varied' })),
      variation && optionRows(app, `${path}.variation`, { of: 'variation' })];
  });
  return part.element;
}

