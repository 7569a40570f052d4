// What a surface of the list has to say once it is chosen: its name, colours, fineness, paint and what is erased of it.

import type { Context } from '../panels/context';
import { optionRows } from '../panels/options';
import { removeValue, setValue } from '../app';
import { isTwoSided, twoSidedOperations } from '../surfaceview';
import type { Json } from '../protocol';
import { button, checkbox, colourField, iconButton, row, textField } from '../ui/controls';
import { h, uid, type Child } from '../ui/dom';
import { section } from '../ui/layout';
import { many } from '../ui/numbers';
import { surfacePath, surfacesOf } from '../store';
import { boundsOf, isClosed, renameOperations } from './drawn';
import { grainRows } from './grains';
import { removeSurface, sizeOf, toggleBounds } from './panel';
import type { Session } from './session';

/** The card under a chosen surface's row. */
export function surfaceMore(context: Context, session: Session, surface: Json, at: number): HTMLElement {
  const { app } = context, { state } = app.store, path = surfacePath(state, at), { kind, name } = surface, id = uid();
  const bounds = boundsOf(state).includes(name), drawn = kind === 'around' || kind === 'chambers';
  return h('div', { class: 'row-more surface-more' },
    row('Name', textField('Name', name, (next) => void rename(session, at, next), { id, key: `${path}.name` }).element, { for: id }),
    colourRows(context, surface, path),
    optionRows(app, `${path}.colours`, { of: 'surface', only: ['blur', 'hide', 'opacity'], more: ['opacity'],
      soft: { blur: [0, Number((sizeOf(state) / 4).toPrecision(2))] } }),
    kind === 'grains' && grainRows(context, surface, path),
    drawn && h('div', null, optionRows(app, path, { of: 'surface', only: ['across', 'along'],
      soft: { across: [8, 256], along: [4, 128] } })),
    kind !== 'body' && row('Bounds the body', checkbox('', bounds, () => void toggleBounds(session, surface, bounds),
      { key: `${path} bounds`, look: 'switch', name: 'Bounds the body', tip: isClosed(surface) ? undefined : 'Only closed surfaces can' }).element,
    { tip: 'The body ends at this surface. Only closed ones can bound it.' }),
    entries(context, surface, path),
    h('div', { class: 'actions' }, button('Remove', () => void removeSurface(session, surface), { icon: 'trash', key: `${path}-` })));
}

async function rename({ app }: Session, at: number, next: string): Promise<void> {
  const { store } = app, name = next.trim(), old = surfacesOf(store.state)[at]?.name as string;
  if (name === '' || name === old) return;
  const { [old]: shown = true, ...others } = store.state.shownSurfaces;
  if (await app.actions.apply(`Call ${old} ${name}`, renameOperations(store.state, at, name))) {
    store.set({ selectedSurface: name, shownSurfaces: shown ? others : { ...others, [name]: false } });
  }
}

/* ---- colours ---------------------------------------------------------------------------------------------------------- */

function colourRows({ app }: Context, surface: Json, path: string): Child {
  const { front, back } = (surface.colours ?? {}) as { front?: string; back?: string }, id = [uid(), uid()];
  const picked = (side: 'front' | 'back'): HTMLElement => iconButton('pick', `The ${side} takes the colour to paint with`,
    () => void setValue(app, `Set surface ${side}`, `${path}.colours.${side}`, app.store.state.paintColour),
    { look: 'plain', key: `${path} pick ${side}` });
  const well = (side: 'front' | 'back', value: string, i: number): HTMLElement => h('span', { class: 'surface-colour' },
    colourField(side === 'front' ? 'Front' : 'Back', value, (colour) => void setValue(app, `Set surface ${side}`, `${path}.colours.${side}`, colour),
      { key: `${path}.colours.${side}`, id: id[i] }).element, picked(side));
  const two = isTwoSided(surface);
  return [row(two ? 'Front' : 'Colour', well('front', front ?? '#ffffff', 0), { for: id[0], tip: 'Of the side that looks outwards; of both while there is one colour.' }),
    two ? row('Back', h('span', { class: 'surface-colour' }, well('back', back ?? front ?? '#ffffff', 1), back !== undefined && iconButton('close', 'One colour for both sides',
      () => void removeValue(app, 'One colour for both sides', `${path}.colours.back`), { look: 'plain', key: `${path} one colour` })), { for: id[1] })
      : row('', button('Another colour inside', () => void app.actions.apply('Two colours', twoSidedOperations(surface, path)),
        { look: 'plain', key: `${path} two colours`, tip: 'Front and back get colours of their own' }))];
}

/* ---- paint, erased parts ------------------------------------------------------------------------------------------------ */

/* What was painted on it and erased from it, each to be taken back by itself. */
function entries({ app }: Context, surface: Json, path: string): Child {
  const paint = (surface.paint ?? []) as Json[], erase = (surface.erase ?? []) as Json[];
  const remove = (key: string, i: number, count: number): (() => void) => () =>
    void removeValue(app, key === 'paint' ? 'Remove paint' : 'Bring back what was erased', count === 1 ? `${path}.${key}` : `${path}.${key}[${i}]`);
  const line = (key: string, text: Child, i: number, count: number): HTMLElement => h('li', { class: 'list-row' },
    h('div', { class: 'list-line' }, h('span', { class: 'list-main' }, text), h('span', { class: 'list-actions' },
      iconButton('trash', key === 'paint' ? 'Remove this paint' : 'Bring this back', remove(key, i, count), { look: 'plain', key: `${path}.${key}[${i}]-` }))));
  const block = (key: string, title: string, all: Json[], text: (entry: Json) => Child): Child => {
    if (all.length === 0) return null;
    const fold = section(`surface.${key}`, `${title} (${all.length})`, { folded: true, inner: true });
    fold.body.append(h('ul', { class: 'list', 'aria-label': title }, all.map((entry, i) => line(key, text(entry), i, all.length))));
    return fold.element;
  };
  const dots = (colours: (string | undefined)[]): Child => h('span', { class: 'colour-dots' }, colours.filter(Boolean).map((colour) =>
    h('span', { class: 'colour-dot', style: `--colour: ${colour}` })));
  const ways: [string, string][] = [['plane', 'Beyond a plane'], ['stroke', 'Along a stroke over the view'],
    ['vertical', 'Along a stroke, along the axis'], ['horizontal', 'Along a stroke, across the axis']];
  return [block('paint', 'Painted', paint, (entry) => [dots([entry.front, entry.back]),
    h('span', null, entry.blur !== undefined ? `Blur ${entry.blur}` : many(entry.brush?.points?.length ?? 0, 'point'))]),
  block('erase', 'Erased', erase, (entry) => h('span', null, ways.find(([key]) => key in entry)?.[1] ?? 'A part')),
  ];
}

