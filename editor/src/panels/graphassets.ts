// What nodes have beside numbers: colours along a line, sinusoids, a matrix, files.

import { removeValue, setValue, type App } from '../app';
import { fileDialog } from '../dialogs/pick';
import type { Json } from '../protocol';
import { labelOf, schemaAt, valueAt } from '../schema';
import { button, colourField, iconButton, row } from '../ui/controls';
import { h, live, type Child } from '../ui/dom';
import { gradient, type Stop } from '../ui/gradient';
import { numberField, slider } from '../ui/slider';

/* ---- stops --------------------------------------------------------------------------------------------------------- */

/** Colours by number, on a bar that spans the numbers there are. */
export function stopsEditor(app: App, path: string, name: string): HTMLElement {
  const host = h('div', { class: 'stops' });
  let chosen = 0;
  const refresh = live(app.store, host, ['document'], (state) => ({ stops: listAt(app, path, state.document), chosen }),
    ({ stops }) => stopsBody(app, path, name, stops, Math.min(chosen, stops.length - 1),
      (next) => { chosen = next; refresh(); }));
  return host;
}

function listAt(app: App, path: string, document = app.store.state.document): Json[] {
  const value = valueAt(document, path);
  return Array.isArray(value) ? value : [];
}

function stopsBody(app: App, path: string, name: string, stops: Json[], chosen: number,
  choose: (index: number) => void): Child {
  const given: Stop[] = stops.map((stop) => ({ at: stop.at, colour: stop.colour, opacity: stop.opacity ?? 1 }));
  const put = (what: string, next: Stop[]): void => void setValue(app, `${what} of ${name}`, path, next.map((stop) =>
    ({ colour: stop.colour, at: stop.at, ...(stop.opacity === 1 ? {} : { opacity: stop.opacity }) })));
  const one = given[chosen];
  const edit = (what: string, change: Partial<Stop>): void => {
    const changed = { ...one, ...change };
    const next = given.map((stop, i) => (i === chosen ? changed : stop)).sort((a, b) => a.at - b.at);
    choose(next.indexOf(changed));
    put(what, next);
  };
  const range = spanOf(given);
  const ramp = gradient(given, { range, word: 'number', chosen, choose, change: (next, what, index) => {
    if (next.length === 0) return app.messages.say('The last colour cannot go.', 'warning');
    choose(Math.max(0, Math.min(index, next.length - 1)));
    put(what, next);
  } });
  return [h('div', { class: 'sub-head' }, h('h4', null, 'Colours by number'),
    h('span', { class: 'ends' }, String(range[0]), h('span', null, String(range[1])))), ramp,
  one && h('div', { class: 'stop-edit' },
    colourField('Colour', one.colour, (colour) => edit('Set colour', { colour }), { key: `${path}.colour` }).element,
    h('span', { class: 'mini-label', 'aria-hidden': 'true' }, 'at'),
    numberField('Number', { min: -1e9, max: 1e9, soft: range }, one.at, (at) => edit('Move colour', { at }),
      { key: `${path}.at` }).element,
    iconButton('trash', 'Remove colour', () => {
      choose(Math.max(0, chosen - 1));
      put('Remove colour', given.filter((_, i) => i !== chosen));
    }, { look: 'plain', key: `${path}-`, disabled: given.length === 1 })),
  one && row('Opacity', slider('Opacity of the colour', { min: 0, max: 1, default: 1 }, one.opacity,
    (opacity) => edit('Set opacity', { opacity }), { key: `${path}.opacity` }).element,
  { tip: '0 is seen through, 1 opaque.' })];
}

/* 0 to 1, and further where colours lie beyond. */
function spanOf(stops: Stop[]): [number, number] {
  const round = (value: number): number => Number(value.toPrecision(3));
  return [Math.min(0, ...stops.map((stop) => round(stop.at))), Math.max(1, ...stops.map((stop) => round(stop.at)))];
}

/* ---- waves --------------------------------------------------------------------------------------------------------- */

/** Sinusoids one by one; without any the function makes its own. */
export function wavesEditor(app: App, path: string, name: string): HTMLElement {
  const host = h('div');
  live(app.store, host, ['document', 'schema'], () => listAt(app, path), (waves) => {
    const add = (): void => void setValue(app, `Add wave to ${name}`, `${path}[${waves.length}]`, { frequency: [1, 0, 0] });
    return [h('div', { class: 'sub-head' }, h('h4', null, 'Waves'),
      iconButton('plus', 'Add wave', add, { look: 'plain', key: `${path}+` })),
    waves.length === 0 && h('p', { class: 'quiet' }, 'Random ones, as the options below say.'),
    waves.length > 0 && h('ol', { class: 'waves' }, waves.map((wave, i) => waveRow(app, `${path}[${i}]`, wave, i, name,
      () => void (waves.length === 1 ? removeValue(app, `Remove wave of ${name}`, path)
        : removeValue(app, `Remove wave of ${name}`, `${path}[${i}]`)))))];
  });
  return host;
}

function waveRow(app: App, place: string, wave: Json, index: number, name: string, remove: () => void): HTMLElement {
  const { state } = app.store, about = schemaAt(state.schema, state.document, place)?.properties ?? {};
  const number = (key: string, spec: object): HTMLElement => {
    const { minimum: min, maximum: max, default: standard } = about[key] ?? {};
    return row(labelOf(key), slider(`${labelOf(key)} of wave ${index + 1}`, { min, max, default: standard, ...spec }, wave[key] ?? standard,
      (value) => void setValue(app, `Set ${key} of ${name}`, `${place}.${key}`, value), { key: `${place}.${key}` }).element,
    { tip: about[key]?.description });
  };
  return h('li', null,
    row(`Wave ${index + 1}`, h('div', { class: 'triple' }, [0, 1, 2].map((axis) =>
      numberField(`Frequency of wave ${index + 1} along ${'xyz'[axis]}`, { min: -1e6, max: 1e6, soft: [-10, 10] }, wave.frequency[axis],
        (value) => void setValue(app, `Set frequency of ${name}`, `${place}.frequency`,
          (wave.frequency as number[]).map((old, k) => (k === axis ? value : old))), { key: `${place}.${axis}` }).element),
    iconButton('trash', `Remove wave ${index + 1}`, remove, { look: 'plain', key: `${place}-` })),
    { tip: about.frequency?.description }),
    number('amplitude', { soft: [-2, 2] }), number('phase', { soft: [-180, 180], unit: '°' }));
}

/* ---- matrix -------------------------------------------------------------------------------------------------------- */

/** Three rows of four numbers; a fourth row, which changes nothing, stays as it is. */
export function matrixRows(app: App, path: string, name: string): HTMLElement {
  const host = h('div');
  live(app.store, host, ['document'], () => listAt(app, path) as unknown as number[][], (matrix) => {
    const put = (r: number, c: number, value: number): void => void setValue(app, `Set matrix of ${name}`, path,
      matrix.map((line, i) => line.map((old, k) => (i === r && k === c ? value : old))));
    return [h('div', { class: 'sub-head' }, h('h4', null, 'Matrix')), h('div', { class: 'matrix' },
      matrix.slice(0, 3).map((line, r) => line.map((value, c) =>
        numberField(`Row ${r + 1}, column ${c + 1}`, { min: -1e9, max: 1e9, soft: [-2, 2] }, value,
          (next) => put(r, c, next), { key: `${path} ${r} ${c}` }).element)))];
  });
  return host;
}

/* ---- files --------------------------------------------------------------------------------------------------------- */

/** A file by its name, and the way to another. */
export function fileRow(app: App, kind: 'image' | 'grid', path: string, name: string, about: string,
  wanted: boolean): HTMLElement {
  const host = h('div');
  live(app.store, host, ['document'], (state) => (valueAt(state.document, path) as string | undefined) ?? null, (file) =>
    row(labelOf(kind), h('div', { class: 'node-file' },
      button(file ? file.split('/').pop()! : 'None', () => fileDialog(app, kind,
        (chosen) => void setValue(app, `Set ${kind} of ${name}`, path, chosen)),
      { icon: kind === 'image' ? 'image' : 'solid', key: path, tip: file ?? `Choose ${about}` }),
      file && !wanted && iconButton('close', `Without the ${kind}`,
        () => void removeValue(app, `Remove ${kind} of ${name}`, path), { look: 'plain', key: `${path}-` })),
    { tip: about }));
  return host;
}
