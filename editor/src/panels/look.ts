// Inspector, "Look": how the model is seen through, pictures of it, and the document's own words.

import { removeValue, setValue, type App } from '../app';
import type { Json } from '../protocol';
import type { Snapshot } from '../pictures';
import { valueAt } from '../schema';
import { button, choice, colourField, iconButton, row, textField } from '../ui/controls';
import { fill, h, live, uid, type Child } from '../ui/dom';
import { gradient, type Stop } from '../ui/gradient';
import { icon } from '../ui/icons';
import { empty, section, setNote } from '../ui/layout';
import { numberField } from '../ui/slider';
import { commandButton, refreshCommand, type Context } from './context';
import { optionRows } from './options';
import { surfacesSection } from './surfaceoptions';

/** The sections of the tab. */
export function lookPanel(context: Context): HTMLElement {
  return h('div', { class: 'panel' }, surfacesSection(context), pictureSection(context), volumeSection(context),
    documentSection(context));
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

const sizes: [string, number, number][] = [
  ['800 × 600', 800, 600], ['1280 × 720', 1280, 720], ['1920 × 1080', 1920, 1080], ['1600 × 1600', 1600, 1600],
  ['3840 × 2160', 3840, 2160],
];

function pictureSection(context: Context): HTMLElement {
  const { app } = context, part = section('picture', 'Picture'), size = h('div'), shots = h('div');
  live(app.store, size, ['document'], (state) => {
    const { width = 800, height = 600 } = state.document.render ?? {};
    return { width, height };
  }, ({ width, height }) => {
    const known = sizes.some(([, w, high]) => w === width && high === height);
    const all = known ? sizes : [[`${width} × ${height}`, width, height] as [string, number, number], ...sizes];
    return row('Size', choice('Size', all.map(([label, w, high]) => ({ value: `${w} ${high}`, label })),
      `${width} ${height}`, (text) => {
      const [w, high] = text.split(' ').map(Number);
      void app.actions.apply('Set picture size', [{ op: 'set', path: 'render.width', value: w },
        { op: 'set', path: 'render.height', value: high }]);
    }, { key: 'picture size' }).element);
  });
  const camera = (): void => void setValue(app, 'Set camera', 'camera', app.viewport.table.toDocument());
  const light = section('picture.light', 'Light and ground', { folded: true, inner: true });
  light.body.append(optionRows(app, 'render', { of: 'picture', skip: ['width', 'height', 'samples'],
    more: ['exposure', 'seed', 'background_red', 'background_green', 'background_blue'] }));
  part.body.append(size, optionRows(app, 'render', { of: 'picture', only: ['samples'] }), h('div', { class: 'actions' },
    commandButton(context, 'snapshot', { icon: 'camera', look: 'main' }),
    button('Keep this view', camera, { tip: 'Makes this the document’s camera', key: 'camera' })), shots,
      light.element);
  const refresh = (): void => fill(shots, snapshotList(context));
  context.pictures.onChange.push(refresh);
  refresh();
  return part.element;
}

function snapshotList({ app, pictures }: Context): Child {
  if (pictures.list.length === 0) return null;
  return h('ul', { class: 'shots', 'aria-label': 'Pictures taken' },
    pictures.list.map((shot) => h('li', { class: 'shot' },
    h('button', { type: 'button', class: 'shot-picture', 'data-tip': 'Look from there again',
      'data-key': `shot ${shot.job}`,
      onclick: () => app.viewport.table.fromDocument(shot.camera) },
    shot.url ? h('img', { src: shot.url, alt: shot.name }) : h('span', { class: 'shot-wait' }, icon('image', 24)),
    shot.state !== 'done' && h('span', { class: 'shot-state' }, shot.state === 'making' ? 'Rendering…' : 'Stopped')),
    h('div', { class: 'shot-words' }, h('span', { class: 'list-text' }, h('span', { class: 'list-title' }, shot.name),
      h('span', { class: 'list-detail' }, `${shot.width} × ${shot.height}`)),
    shot.url && iconButton('download', 'Download', () => download(shot), { look: 'plain', key: `load ${shot.job}` }),
    iconButton('trash', 'Remove', () => pictures.remove(shot), { look: 'plain', key: `drop ${shot.job}` })))));
}

function download(shot: Snapshot): void {
  const link = h('a', { href: shot.url, download: shot.name });
  document.body.append(link);
  link.click();
  link.remove();
}

/* ---- seen through ------------------------------------------------------------------------------------------------ */

function volumeSection({ app }: Context): HTMLElement {
  const { store } = app, part = section('volume', 'Volume', { folded: true }), host = h('div');
  part.body.append(host);
  live(store, host, ['document'], (state) => ({ there: state.document.volume !== undefined }), ({ there }) => {
    setNote(part, there ? 'on' : null);
    if (!there) {
      return empty('The document’s pictures show the skin. They can look through it instead, as through glass.',
        button('See through', () => void setValue(app, 'See through', 'volume', {}), { icon: 'cloud', key: 'volume' }));
    }
    return [transferEditor(app), optionRows(app, 'volume', {
      of: 'volume', only: ['opacity', 'unit', 'channel', 'shading', 'slices', 'samples', 'method', 'light_azimuth',
        'light_elevation', 'exposure',
        'transparent', 'jitter', 'width', 'height', 'background_red', 'background_green', 'background_blue', 'seed'],
      more: ['method', 'light_azimuth', 'light_elevation', 'exposure', 'transparent', 'jitter', 'width', 'height',
        'background_red', 'background_green', 'background_blue', 'seed'],
    }), h('div', { class: 'actions' }, button('Show the skin again',
    () => void removeValue(app, 'Show the skin', 'volume'), { look: 'plain', key: 'no volume' }))];
  });
  return part.element;
}

function transferEditor(app: App): HTMLElement {
  const host = h('div', { class: 'stops' }), path = 'volume.transfer';
  let chosen = 0;
  const refresh = live(app.store, host, ['document'],
    (state) => ({ points: (valueAt(state.document, path) ?? []) as Json[], chosen }), ({ points }) =>
    transferBody(app, path, points, Math.min(chosen, points.length - 1), (next) => { chosen = next; refresh(); }));
  return host;
}

function transferBody(app: App, path: string, points: Json[], chosen: number, choose: (index: number) => void): Child {
  const given: Stop[] = points.map((point) => ({ at: point.value, colour: point.colour, opacity: point.opacity ?? 1 }));
  const write = (name: string, next: Stop[]): void => void (next.length
    ? setValue(app, name, path, next.map((stop) => ({ value: stop.at, colour: stop.colour, opacity: stop.opacity })))
    : removeValue(app, name, path));
  const head = h('div', { class: 'sub-head' }, h('h4', null, 'Colours by value'));
  if (given.length === 0) {
    const start = [{ at: 0, colour: '#000000', opacity: 0 }, { at: 1, colour: '#ffffff', opacity: 1 }];
    return [head, empty('The solid’s own colours and opacity show.',
      button('Colour by value', () => write('Colour by value', start), { key: 'transfer' }))];
  }
  const range = rangeOf(given), one = given[chosen];
  const edit = (name: string, change: Partial<Stop>): void => {
    const changed = { ...one, ...change };
    const next = given.map((stop, i) => (i === chosen ? changed : stop)).sort((a, b) => a.at - b.at);
    choose(next.indexOf(changed));
    write(name, next);
  };
  return [head, gradient(given, { range, word: 'value', heights: true, chosen, choose, change: (next, what, index) => {
    choose(Math.max(0, Math.min(index, next.length - 1)));
    write(what, next);
  } }),
  h('div', { class: 'stop-edit' },
    colourField('Colour', one.colour, (colour) => edit('Set colour', { colour }), { key: 'transfer.colour' }).element,
    h('span', { class: 'mini-label', 'aria-hidden': 'true' }, 'at'),
    numberField('Value', { min: -1e9, max: 1e9, soft: range }, one.at, (at) => edit('Move stop', { at }),
      { key: 'transfer.value' }).element,
    h('span', { class: 'mini-label', 'aria-hidden': 'true' }, '×'),
    numberField('Opacity', { min: 0, max: 1 }, one.opacity, (opacity) => edit('Set opacity', { opacity }),
      { key: 'transfer.opacity' }).element,
    iconButton('trash', 'Remove stop', () => write('Remove stop', given.filter((_, i) => i !== chosen)),
      { look: 'plain', key: 'transfer-' }))];
}

/* What the bar spans: 0 to 1, and further where stops lie beyond. */
function rangeOf(stops: Stop[]): [number, number] {
  const most = Math.max(...stops.map((stop) => stop.at)), least = Math.min(...stops.map((stop) => stop.at));
  // Where all stops crowd near 0, as densities do, the bar ends a little after them.
  const high = most > 1 ? most : most > 0.2 ? 1 : Number((most * 1.5 || 1).toPrecision(2));
  return [Math.min(0, least), high];
}

/* ---- document ---------------------------------------------------------------------------------------------------- */

function documentSection(context: Context): HTMLElement {
  const { app } = context, { store } = app, part = section('document', 'Document'), facts = h('dl', { class: 'facts' });
  const id = uid(), title = textField('Title', '',
    (text) => void (text ? setValue(app, 'Set title', 'title', text) : removeValue(app, 'Remove title', 'title')),
    { id, key: 'title' });
  const revert = commandButton(context, 'revert', { look: 'plain' });
  part.body.append(row('Title', title.element, { for: id, tip: 'A name for people.' }), facts,
    h('div', { class: 'actions' },
    commandButton(context, 'save', { icon: 'save' }), commandButton(context, 'save-as'), revert));
  const refresh = (): void => {
    refreshCommand(context, revert, 'revert');
    const { document, path, version } = store.state;
    if (globalThis.document.activeElement !== title.element) title.set(document.title ?? '');
    fill(facts, path && [h('dt', null, 'File'), h('dd', { title: path }, path)],
      version && [h('dt', null, 'pith'), h('dd', null, version)]);
  };
  store.on(['document', 'path', 'version', 'saved'], refresh);
  refresh();
  return part.element;
}
