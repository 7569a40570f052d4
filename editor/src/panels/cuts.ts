// Inspector, "Cuts": the cuts in their order, and the parts they leave.

import { operate, setValue } from '../app';
import type { Json } from '../protocol';
import { anyMoved, bringTogether, hidePart, partNames } from '../parts';
import { button, checkbox, iconButton, row, segmented } from '../ui/controls';
import { h, live } from '../ui/dom';
import { empty, list, listRow, section, setNote } from '../ui/layout';
import { many } from '../ui/numbers';
import { slider } from '../ui/slider';
import { commandButton, keyOf, type Context } from './context';
import { pointWords } from './fields';
import { optionRows } from './options';

/** The sections of the tab. */
export function cutsPanel(context: Context): HTMLElement {
  return h('div', { class: 'panel' }, cutsSection(context), partsSection(context));
}

function cutsSection(context: Context): HTMLElement {
  const { app } = context, { store } = app, part = section('cuts', 'Cuts');
  live(store, part.body, ['document', 'chosenCut'],
    (state) => ({ cuts: (state.document.cuts ?? []) as Json[], chosen: state.chosenCut }),
    ({ cuts, chosen }) => {
      setNote(part, cuts.length ? String(cuts.length) : null);
      const add = h('div', { class: 'actions' },
        button('Draw a cut', () => store.set({ tool: 'cut' }),
          { icon: 'cut', keys: keyOf(context, 'cut'), key: 'add-cut' }),
        button('Plane', () => store.set({ tool: 'plane' }),
          { icon: 'plane', keys: keyOf(context, 'plane'), key: 'add-plane' }));
      if (cuts.length === 0) return [empty('Nothing is cut. Draw a line across the model to see its inside.'), add];
      return [list('Cuts, in order', cuts.map((cut, i) => cutRow(context, cut, i, i === chosen))), add];
    });
  return part.element;
}

function cutRow(context: Context, cut: Json, index: number, chosen: boolean): HTMLElement {
  const { app } = context, { store } = app, path = `cuts[${index}]`, keep = cut.keep ?? 'both';
  const kind = cut.plane ? 'Plane' : 'Stroke';
  const remove = (): void => {
    void operate(app, 'Remove cut', { op: 'cut.remove', index });
    store.set({ chosenCut: null });
  };
  return listRow({
    icon: cut.plane ? 'plane' : 'stroke', text: `${kind} ${index + 1}`, chosen, key: path,
    choose: () => store.set({ chosenCut: chosen ? null : index }),
    tip: chosen ? undefined : 'Show its options; Delete removes it',
    detail: cut.plane ? `across ${pointWords(cut.plane.normal)}` : many(cut.stroke?.points?.length ?? 0, 'point'),
    actions: [
      segmented('What stays', [
        { value: 'positive', label: cut.plane ? 'The side the normal points to stays'
          : 'What lies right of the stroke stays', icon: 'upper' },
        { value: 'negative', label: cut.plane ? 'The other side stays' : 'What lies left of the stroke stays',
          icon: 'lower' },
        { value: 'both', label: 'Both sides stay', icon: 'both' },
      ], keep, (value) => void setValue(app, 'Keep other side', `${path}.keep`, value),
        { key: `${path}.keep`, icons: 'only' }).element,
      iconButton('trash', 'Remove cut', remove, { look: 'plain',
        keys: chosen ? context.commands.get('delete').keys[0] : undefined, key: `${path}-` }),
    ],
    more: chosen && cutMore(context, cut, path, keep),
  });
}

function cutMore({ app }: Context, cut: Json, path: string, keep: string): HTMLElement {
  const gap = { min: 0, max: 1e9, default: 0, soft: [0, app.model.diagonal() / 2] as [number, number] };
  return h('div', { class: 'row-more' },
    keep === 'both' && row('Gap', slider('Gap', gap, cut.gap ?? 0,
      (value) => void setValue(app, 'Set gap', `${path}.gap`, value),
      { key: `${path}.gap` }).element, { tip: 'How far both sides are moved apart.' }),
    row('Separate pieces', checkbox('', cut.separate ?? false,
      (on) => void setValue(app, on ? 'Separate pieces' : 'Join pieces', `${path}.separate`, on),
      { key: `${path}.separate`, look: 'switch', name: 'Separate pieces' }).element,
        { tip: 'Pieces that do not hang together become parts of their own.' }),
    cut.stroke && optionRows(app, `${path}.stroke`, { of: 'cut' }));
}

/* ---- parts ------------------------------------------------------------------------------------------------------- */

function partsSection(context: Context): HTMLElement {
  const { app } = context, { store } = app, part = section('parts', 'Parts');
  const rows = h('div'), pull = pullApart(context);
  part.body.append(rows, pull);
  live(store, rows, ['serial', 'part', 'bodies', 'document'], (state) => ({
    parts: app.model.parts.map((each) => ({ hidden: each.hidden, body: each.body })), picked: state.part,
    names: partNames(app), cut: (state.document.cuts ?? []).length > 0,
    moved: anyMoved(state.document),
  }), ({ parts, picked, names, moved, cut }) => {
    setNote(part, parts.length ? String(parts.length) : null);
    pull.hidden = parts.length < 2;
    if (parts.length === 0) return empty(cut ? 'The cuts leave nothing.' : 'There is nothing to see yet.');
    const hidden = parts.filter((each) => each.hidden).length;
    return [list('Parts', parts.map((each, i) => listRow({
      icon: 'solid', text: names[i], chosen: picked === i, key: `part ${i}`, detail: each.hidden ? 'hidden' : undefined,
      choose: () => store.set({ part: picked === i ? null : i, body: each.body }),
      actions: iconButton(each.hidden ? 'hidden' : 'eye', each.hidden ? `Show ${names[i]}` : `Hide ${names[i]}`,
        () => void hidePart(app, i, !each.hidden),
        { look: 'plain', key: `eye ${i}`, keys: picked === i ? context.commands.get('hide').keys[0] : undefined }),
    }))), (hidden > 0 || moved) && h('div', { class: 'actions' },
      hidden > 0 && commandButton(context, 'show-all', { icon: 'eye' }),
      moved && button('Bring together', () => void bringTogether(app),
        { icon: 'together', key: 'together', tip: 'Parts moved by hand go back to where the cuts left them' }))];
  });
  return part.element;
}

function pullApart({ app }: Context): HTMLElement {
  const { store } = app, pull = (apart: number): void => store.set({ apart });
  const control = slider('Pull apart', { min: 0, max: 1, default: 0 }, store.state.apart, pull,
    { key: 'apart', moving: pull });
  store.on(['apart'], () => control.set(store.state.apart));
  return row('Pull apart', control.element,
    { tip: 'Moves parts away from the middle, for looking only; the document stays as it is.' });
}
