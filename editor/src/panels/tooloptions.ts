// What the chosen tool can be told, in a bar over the view.

import type { Vector3 } from 'three';
import { bodyJson, solidOf, type ToolName } from '../store';
import { button, checkbox, choice, iconButton, segmented } from '../ui/controls';
import { fill, h, set, type Child } from '../ui/dom';
import { slider } from '../ui/slider';
import { write } from '../ui/numbers';
import { paletteCss } from '../view/looks';
import { commandButton, type Context } from './context';
import { exemplarName, exemplarsOf } from './exemplars';
import { eraseOptions, paintOptions } from './surfaceoptions';

/** Builds the bar; it is gone while the tool has nothing to be told. */
export function toolOptions(context: Context): HTMLElement {
  const { store } = context.app;
  const bar = h('div', { class: 'tool-options', role: 'toolbar', 'aria-label': 'Options of the tool' });
  const refresh = (): void => {
    const made = optionsOf(context, store.state.tool);
    bar.hidden = made.length === 0;
    fill(bar, made);
  };
  store.on(['tool', 'part', 'erase', 'keep', 'separate', 'pasting', 'body', 'types', 'paintWhat'], refresh);
  refresh();
  return bar;
}

function optionsOf(context: Context, tool: ToolName): Child[] {
  switch (tool) {
    case 'select': return partOptions(context);
    case 'cut': return cutOptions(context);
    case 'plane': return planeOptions(context);
    case 'fill': return [depthPalette(context, true), creaseSlider(context)];
    case 'face': return [depthPalette(context, true)];
    case 'depth': case 'points': return [depthPalette(context, false), layerSlider(context)];
    case 'direction': return bodyJson(context.app.store.state).depth ? [layerSlider(context), linesSwitch(context)]
      : [linesSwitch(context)];
    case 'scale': return [sizeSlider(context)];
    case 'paste': return [pasteChoice(context), sizeSlider(context)];
    case 'paint-surface': return paintOptions(context);
    case 'erase-surface': return eraseOptions(context);
  }
}

/** A control with a word before it. */
export function labelled(label: string, control: HTMLElement, narrow = false): HTMLElement {
  return h('div', { class: narrow ? 'option narrow' : 'option' },
    h('span', { class: 'option-label', 'aria-hidden': 'true' }, label), control);
}

function partOptions(context: Context): Child[] {
  if (context.app.store.state.part === null) return [];
  return [commandButton(context, 'hide', { icon: 'hidden' }), commandButton(context, 'show-all', { icon: 'eye' })];
}

function cutOptions({ app }: Context): Child[] {
  const { store } = app;
  return [
    labelled('Keep', segmented('What stays', [
      { value: 'positive', label: 'Right', icon: 'upper', tip: 'What lies right of the stroke stays' },
      { value: 'negative', label: 'Left', icon: 'lower',
        tip: 'What lies left of the stroke stays; the same as holding Shift' },
      { value: 'both', label: 'Both', icon: 'both', tip: 'Both sides stay, apart; the same as holding Alt' },
    ], store.state.keep, (keep) => store.set({ keep }), { key: 'keep' }).element),
    checkbox('Separate pieces', store.state.separate, (separate) => store.set({ separate }),
      { key: 'separate', tip: 'Pieces that do not hang together become parts of their own' }).element,
  ];
}

interface Plane { turn(normal: Vector3): void; flip(): void; commit(keep: 'negative' | 'both'): void }

function planeOptions({ app }: Context): Child[] {
  const plane = app.toolbox.get('plane') as unknown as Plane | undefined;
  if (!plane) return [];
  const { camera, target } = app.viewport.table;
  // Enter, pressed next, is to cut, not to press the same button once more.
  const then = (act: () => void) => (): void => { act(); app.viewport.canvas.focus({ preventScroll: true }); };
  const towards = (axis: 'x' | 'y' | 'z') => (): void => {
    const eye = camera.position.clone().sub(target), normal = eye.clone().set(0, 0, 0);
    normal[axis] = Math.sign(eye[axis]) || 1;
    plane.turn(normal);
  };
  return [
    labelled('Across', h('div', { class: 'pair' }, (['x', 'y', 'z'] as const).map((axis) =>
      button(axis.toUpperCase(), then(towards(axis)), { tip: `Across the ${axis} axis`, class: 'square' })))),
    button('Facing me', then(() => plane.turn(camera.position.clone().sub(target))),
      { tip: 'Turn the plane to face the eye' }),
    iconButton('flip', 'Other side', then(() => plane.flip())),
    button('Cut', () => plane.commit('negative'), { look: 'main', icon: 'cut', keys: 'Enter',
      tip: 'Cut here; what the arrow points to goes' }),
    button('Cut, keep both', () => plane.commit('both'), { icon: 'both', tip: 'Cut here; both sides stay, apart' }),
  ];
}

/* The five depths of the thesis (2011, §4.4.1), one's own, and none. */
function depthPalette({ app }: Context, erasing: boolean): HTMLElement {
  const { store } = app, { palette } = store.state;
  const take = (paint: number): void => store.set({ paint, erase: false });
  const swatches = palette.map((depth) => h('button', {
    type: 'button', role: 'radio', class: 'depth-swatch', 'data-depth': depth, 'data-key': `depth=${depth}`,
    'aria-label': `Depth ${depth}`,
    'data-tip': depth === 0 ? 'Depth 0, the outside' : depth === 1 ? 'Depth 1, the core' : `Depth ${depth}`,
    onclick: () => take(depth),
  }, h('span', { class: 'depth-colour', style: `--colour: ${paletteCss(depth)}` }), h('span', null, write(depth))));
  const none = erasing && h('button', { type: 'button', role: 'radio', class: 'depth-swatch', 'data-key': 'depth=none',
    'aria-label': 'Take paint off', 'data-tip': 'Take paint off', onclick: () => store.set({ erase: true }) },
  h('span', { class: 'depth-colour none' }), h('span', null, 'none'));
  const own = slider('Depth', { min: 0, max: 1, default: 0 }, store.state.paint, take, { key: 'paint', moving: take });
  const refresh = (): void => {
    const { paint, erase } = store.state;
    for (const swatch of swatches) set(swatch, 'aria-checked', !erase && Number(swatch.dataset.depth) === paint);
    if (none) set(none, 'aria-checked', erase);
    own.set(paint);
  };
  const stop = store.on(['paint'], () => (made.isConnected ? refresh() : stop()));
  const made = h('div', { class: 'option' },
    h('div', { class: 'depth-palette', role: 'radiogroup', 'aria-label': 'Depth' }, swatches, none), own.element);
  refresh();
  return made;
}

function creaseSlider({ app }: Context): HTMLElement {
  const { store } = app;
  return labelled('Crease', slider('Crease angle', { min: 0, max: 180, default: 30, unit: '°' }, store.state.crease,
    (crease) => store.set({ crease }), { key: 'crease' }).element);
}

/** The slider of the layer that is looked at, with a switch for none. */
export function layerSlider({ app }: Context): HTMLElement {
  const { store } = app;
  const set = (layer: number): void => store.set({ layer });
  const control = slider('Layer', { min: 0, max: 1, default: 0.5 }, store.state.layer ?? 0.5, set,
    { key: 'layer', moving: set });
  const off = checkbox('Layer', store.state.layer !== null, (on) => store.set({ layer: on ? 0.5 : null }),
    { key: 'layer-on', tip: 'Look at the surface of one depth', look: 'switch' });
  const stop = store.on(['layer'], () => {
    if (!made.isConnected) return stop();
    off.set(store.state.layer !== null);
    if (store.state.layer !== null) control.set(store.state.layer);
    made.classList.toggle('off', store.state.layer === null);
  });
  const made = h('div', { class: `option ${store.state.layer === null ? 'off' : ''}` }, off.element, control.element);
  return made;
}

function linesSwitch({ app }: Context): HTMLElement {
  const { store } = app;
  const control = checkbox('Streamlines', store.state.lines !== 'none',
    (on) => store.set({ lines: on ? (store.state.layer === null ? 'body' : 'layer') : 'none' }),
    { key: 'lines', look: 'switch' });
  const stop = store.on(['lines'], () =>
    (control.element.isConnected ? control.set(store.state.lines !== 'none') : stop()));
  return control.element;
}

function sizeSlider({ app }: Context): HTMLElement {
  const { store } = app, diagonal = app.model.diagonal();
  const spec = { min: 1e-9, max: 1e9, soft: [diagonal / 200, diagonal] as [number, number] };
  const set = (size: number): void => store.set({ size });
  const control = slider('Size', spec, store.state.size || diagonal / 4, set, { key: 'size', moving: set });
  const stop = store.on(['size'], () => (control.element.isConnected ? control.set(store.state.size) : stop()));
  return labelled('Size', control.element);
}

function pasteChoice(context: Context): Child {
  const { store } = context.app, known = exemplarsOf(store.state.document);
  const chosen = JSON.stringify(store.state.pasting ?? solidOf(store.state)?.json.exemplar ?? null);
  const choices = known.map((exemplar) => ({ value: JSON.stringify(exemplar), label: exemplarName(exemplar) }));
  if (chosen !== 'null' && !choices.some((each) => each.value === chosen)) {
    choices.push({ value: chosen, label: exemplarName(JSON.parse(chosen)) });
  }
  return labelled('Exemplar', h('div', { class: 'pair' },
    choice('Exemplar', choices, chosen, (text) => store.set({ pasting: JSON.parse(text) }), { key: 'pasting' }).element,
    iconButton('folder', 'Another exemplar…', () => context.chooseExemplar('Exemplar to paste',
      (pasting) => store.set({ pasting })))));
}
