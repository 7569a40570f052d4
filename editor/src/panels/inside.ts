// Inspector, "Inside": which body, its texture type and exemplar, how it is filled, and what is pasted on top.

import { operate, setValue } from '../app';
import type { BodyState, Json } from '../protocol';
import { bodyJson, solidOf, type State } from '../store';
import { typeFacts } from '../types';
import { button, choice, iconButton, row } from '../ui/controls';
import { h, live, set, type Child } from '../ui/dom';
import { badge, empty, list, listRow, section, setNote } from '../ui/layout';
import { numberField } from '../ui/slider';
import { commandButton, keyOf, pointAt, type Context } from './context';
import { Cube, exemplarName, typePicture } from './exemplars';
import { computedCard, graphSection } from './graph';
import { optionRows } from './options';

/** The sections of the tab, in order. */
export function insidePanel(context: Context, recipe: HTMLElement, shape: HTMLElement): HTMLElement {
  return h('div', { class: 'panel' }, bodiesSection(context), textureSection(context), graphSection(context), recipe, pastesSection(context),
    shape);
}

/** A body's state in a word and a colour. */
export function bodyWord(body: BodyState, busy: boolean): { word: string; tone: 'good' | 'due' | 'bad' | 'plain' } {
  if (body.why) return { word: 'Needs something', tone: 'bad' };
  if (body.built.solid && body.shown) return { word: 'Built', tone: 'good' };
  return busy ? { word: 'Working…', tone: 'due' } : { word: 'Needs update', tone: 'due' };
}

/** Is something being built? */
export function isBusy(state: State): boolean {
  return state.jobs.some((job) => (job.state === 'running' || job.state === 'waiting') && job.what !== 'picture');
}

function bodiesSection({ app }: Context): HTMLElement {
  const { store } = app, part = section('bodies', 'Bodies');
  live(store, part.body, ['bodies', 'body', 'jobs', 'document'], (state) =>
    ({ bodies: state.bodies, chosen: state.body, busy: isBusy(state), title: state.document.title }),
    ({ bodies, chosen, busy, title }) => {
    if (bodies.length === 0) return empty('There is no body yet.');
    setNote(part, bodies.length > 1 ? String(bodies.length) : null);
    return list('Bodies', bodies.map((body, i) => {
      const { word, tone } = bodyWord(body, busy);
      const name = body.name || title || 'Body';
      return listRow({
        icon: 'body', text: name, key: `body ${i}`, chosen: bodies.length > 1 && i === chosen,
        choose: bodies.length > 1 ? () => store.set({ body: i }) : undefined,
        detail: body.why, actions: [body.type && badge(body.type, 'plain', typeFacts(body.type)?.name),
          badge(word, tone)],
      });
    }));
  });
  return part.element;
}

/* ---- texture ----------------------------------------------------------------------------------------------------- */

function textureSection(context: Context): HTMLElement {
  const { app } = context, { store } = app, part = section('texture', 'Texture');
  const kind = h('div'), options = h('div');
  const cube = new Cube(app, 92), exemplar = exemplarCard(context, cube);
  part.body.append(kind, exemplar, options);
  live(store, kind, ['document', 'body', 'types'], (state) => {
    const body = bodyJson(state), solid = solidOf(state);
    return { names: ((body.solids ?? []) as Json[]).map((each) => each.name as string), name: solid?.json.name,
      kind: solid?.json.kind,
             type: solid?.json.type ?? '1-B' };
  }, (what) => {
    if (what.names.length === 0) {
      return empty('This body is made of nothing yet. Choose a texture type, and it gets an inside.',
        commandButton(context, 'type', { look: 'main' }));
    }
    return [what.names.length > 1 && row('Made of',
      choice('Made of', what.names.map((value) => ({ value, label: value })), what.name,
      (name) => void operate(app, `Make it of ${name}`, { op: 'solid.choose', name }), { key: 'solid' }).element),
    what.kind === 'lapped' ? typeCard(context, what.type)
      : what.kind === 'procedural' ? computedCard(context)
        : h('p', { class: 'quiet' }, kindWords[what.kind] ?? '')];
  });
  let shown = '';
  const refresh = (): void => {
    const solid = solidOf(store.state), text = solid ? `${solid.place} ${solid.json.kind}` : '';
    exemplar.hidden = solid?.json.kind !== 'lapped';
    if (text === shown) return;
    shown = text;
    options.replaceChildren(...(solid ? [solid.json.kind === 'lapped' ? fillOptions(context, solid.place)
      : optionRows(app, solid.place, { skip: ['name'] })] : []));
  };
  store.on(['document', 'body'], refresh);
  refresh();
  return part.element;
}

function typeCard(context: Context, type: string): Child {
  const facts = typeFacts(type);
  return h('button', { type: 'button', class: 'type-card', 'data-key': 'type', 'data-tip': 'Choose the texture type',
    'data-tip-keys': context.commands.get('type').keys[0],
    onclick: () => context.chooseType() },
  typePicture(type, 'type-mark'),
  h('span', { class: 'list-text' }, h('span', { class: 'list-title' }, facts?.name ?? type),
    h('span', { class: 'list-detail' }, facts?.follows ?? '')), h('span', { class: 'type-change' }, 'Change…'));
}

function exemplarCard(context: Context, cube: Cube): HTMLElement {
  const { app } = context, { store } = app;
  const name = h('span', { class: 'list-title' }), about = h('span', { class: 'list-detail', 'aria-live': 'polite' });
  const replace = (): void => context.chooseExemplar('Exemplar', (exemplar) => {
    const solid = solidOf(store.state);
    if (solid) void setValue(app, `Take ${exemplarName(exemplar)}`, `${solid.place}.exemplar`, exemplar);
  });
  const made = h('div', { class: 'exemplar-card' }, cube.canvas, h('div', { class: 'exemplar-words' },
    h('span', { class: 'list-text' }, name, about), button('Replace…', replace, { key: 'replace' })));
  const refresh = async (): Promise<void> => {
    const { state } = store, solid = solidOf(state);
    if (solid?.json.kind !== 'lapped' || state.connection !== 'open') return;
    const { exemplar } = solid.json;
    name.textContent = exemplarName(exemplar);
    // Asked for the exemplar itself, so that a change of it is seen before the model is built again.
    const refused = await cube.show({ exemplar }, state.connection);
    const size = cube.voxels?.size;
    about.textContent = refused ?? (size ? `${size.join(' × ')} voxels` : '');
    set(cube.canvas, 'aria-label', `Exemplar ${exemplarName(exemplar)}`);
  };
  store.on(['document', 'body', 'connection'], () => void refresh());
  void refresh();
  return made;
}

const kindWords: { [kind: string]: string } = {
  grid: 'A voxel grid, as it is in its file.', diffusion: 'Colours that flow between the body’s surfaces.',
  combined: 'The colour of one solid with the grain of others on it.',
};

function fillOptions({ app }: Context, place: string): HTMLElement {
  return optionRows(app, place, {
    of: 'fill', skip: ['name', 'type'],
    more: ['roughness', 'scale_bound', 'scale_floor', 'tolerance', 'regrow_limit', 'jitter', 'seed'],
  });
}

/* ---- pastes ------------------------------------------------------------------------------------------------------ */

function pastesSection(context: Context): HTMLElement {
  const { app } = context, { store } = app, part = section('pastes', 'Pastes', { folded: true });
  live(store, part.body, ['document', 'body'], (state) => {
    const solid = solidOf(state);
    return { lapped: solid?.json.kind === 'lapped', place: solid?.place ?? '',
      pastes: (solid?.json.pastes ?? []) as Json[] };
  }, ({ lapped, place, pastes }) => {
    part.show(lapped);
    setNote(part, pastes.length ? String(pastes.length) : null);
    if (pastes.length === 0) {
      return empty('Nothing is pasted on top. Set single things where you want them: cherries on a cake.',
        button('Paste with the tool', () => store.set({ tool: 'paste' }),
          { icon: 'paste', keys: keyOf(context, 'paste') }));
    }
    const diagonal = app.model.diagonal();
    return list('Pastes, the last on top', pastes.map((paste, i) => listRow({
      icon: 'paste', point: pointAt(app, `paste ${i}`), text: exemplarName(paste.exemplar),
      detail: `${i + 1} of ${pastes.length}`, actions: [
        numberField('Size', { min: 1e-9, max: 1e9, soft: [diagonal / 200, diagonal] }, paste.size,
          (size) => void operate(app, 'Size of paste', { op: 'paste.move', index: i, size }),
          { key: `paste ${i}` }).element,
        iconButton('trash', 'Remove', () => void operate(app, 'Remove paste', { op: 'paste.remove', index: i }),
          { look: 'plain', key: `paste- ${i}` }),
      ],
      more: pasteMore(context, `${place}.pastes[${i}]`, i),
    })));
  });
  return part.element;
}

function pasteMore({ app }: Context, place: string, index: number): HTMLElement {
  const fold = section(`paste.${index}`, 'Edge', { folded: true, inner: true });
  fold.body.append(optionRows(app, place, { only: ['mask_radius', 'drop_off'], of: 'paste' }));
  return fold.element;
}
